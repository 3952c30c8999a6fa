"""rclpy.topic_endpoint_info: information about a publisher or subscription in the graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Self, TypedDict, TypeVar, Unpack

from goalwire.transport.contract import GraphEntity
from rclpy._reexports import reexport
from rclpy.qos import HistoryPolicy, QoSPresetProfiles, QoSProfile
from rclpy.type_hash import TypeHash

T = TypeVar('T')


class TopicEndpointTypeEnum(IntEnum):
    """The kinds of endpoints of a topic."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


class _Fields(TypedDict, total=False):
    node_name: str
    node_namespace: str
    topic_type: str
    topic_type_hash: TypeHash | Mapping[str, object]
    endpoint_type: int
    endpoint_gid: Sequence[int]
    qos_profile: QoSProfile | Mapping[str, object]


def _check(what: str, value: object, kind: type[T]) -> T:
    if not isinstance(value, kind):
        raise AssertionError(f'{what} must be {kind.__name__}, got {value!r}')  # noqa: TRY004 - rclpy's own type
    return value


class TopicEndpointInfo:
    """A publisher or subscription in the graph: its node, type and QoS.

    A value of a wrong type raises AssertionError, as in rclpy.
    """

    __slots__ = [
        '_endpoint_gid',
        '_endpoint_type',
        '_node_name',
        '_node_namespace',
        '_qos_profile',
        '_topic_type',
        '_topic_type_hash',
    ]

    def __init__(self, **kwargs: Unpack[_Fields]) -> None:
        unknown = kwargs.keys() - {slot[1:] for slot in self.__slots__}
        if unknown:
            raise AssertionError(f'Invalid arguments passed to constructor: {", ".join(sorted(unknown))}')
        self.node_name = kwargs.get('node_name', '')
        self.node_namespace = kwargs.get('node_namespace', '')
        self.topic_type = kwargs.get('topic_type', '')
        self.topic_type_hash = kwargs.get('topic_type_hash', TypeHash())
        self.endpoint_type = kwargs.get('endpoint_type', TopicEndpointTypeEnum.INVALID)
        self.endpoint_gid = kwargs.get('endpoint_gid', [])
        self.qos_profile = kwargs.get('qos_profile', QoSPresetProfiles.UNKNOWN.value)

    @classmethod
    def from_entity(cls, entity: GraphEntity) -> Self:
        """Return the information about an endpoint in the graph."""
        return cls(
            node_name=entity.node.name,
            node_namespace=entity.node.namespace,
            topic_type=entity.type_name,
            topic_type_hash=TypeHash.from_text(entity.type_hash),
            endpoint_type=TopicEndpointTypeEnum[entity.kind.name],
            endpoint_gid=list(entity.gid),
            qos_profile=QoSProfile.from_core(entity.qos),
        )

    @property
    def node_name(self) -> str:
        """The name of the node that owns the endpoint."""
        return self._node_name

    @node_name.setter
    def node_name(self, value: str) -> None:
        self._node_name = _check('node_name', value, str)

    @property
    def node_namespace(self) -> str:
        """The namespace of the endpoint's node."""
        return self._node_namespace

    @node_namespace.setter
    def node_namespace(self, value: str) -> None:
        self._node_namespace = _check('node_namespace', value, str)

    @property
    def topic_type(self) -> str:
        """The topic's type, for example 'std_msgs/msg/String'."""
        return self._topic_type

    @topic_type.setter
    def topic_type(self, value: str) -> None:
        self._topic_type = _check('topic_type', value, str)

    @property
    def topic_type_hash(self) -> TypeHash:
        """The type's hash. It may also be set by a mapping of TypeHash's arguments."""
        return self._topic_type_hash

    @topic_type_hash.setter
    def topic_type_hash(self, value: TypeHash | Mapping[str, object]) -> None:
        if isinstance(value, Mapping):
            value = TypeHash(**value)  # type: ignore[arg-type]
        self._topic_type_hash = _check('topic_type_hash', value, TypeHash)

    @property
    def endpoint_type(self) -> TopicEndpointTypeEnum:
        """Publisher or subscription. It may also be set by the number."""
        return self._endpoint_type

    @endpoint_type.setter
    def endpoint_type(self, value: int) -> None:
        self._endpoint_type = TopicEndpointTypeEnum(_check('endpoint_type', value, int))

    @property
    def endpoint_gid(self) -> Sequence[int]:
        """The endpoint's id on the wire, as a list of bytes."""
        return self._endpoint_gid

    @endpoint_gid.setter
    def endpoint_gid(self, value: Sequence[int]) -> None:
        if not isinstance(value, Sequence):
            raise AssertionError(f'endpoint_gid must be a sequence of int, got {value!r}')  # noqa: TRY004
        for byte in value:
            _check('each byte of endpoint_gid', byte, int)
        self._endpoint_gid = value

    @property
    def qos_profile(self) -> QoSProfile:
        """The endpoint's QoS. It may also be set by a mapping of QoSProfile's arguments."""
        return self._qos_profile

    @qos_profile.setter
    def qos_profile(self, value: QoSProfile | Mapping[str, object]) -> None:
        if isinstance(value, Mapping):
            value = QoSProfile(**value)  # type: ignore[arg-type]
        self._qos_profile = _check('qos_profile', value, QoSProfile)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TopicEndpointInfo):
            return False
        return all(getattr(self, slot) == getattr(other, slot) for slot in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        """Return the text that `ros2 topic info --verbose` prints."""
        qos = self.qos_profile
        depth = f' ({qos.depth})' if qos.history is HistoryPolicy.KEEP_LAST else ''
        return '\n'.join(
            [
                f'Node name: {self.node_name}',
                f'Node namespace: {self.node_namespace}',
                f'Topic type: {self.topic_type}',
                f'Topic type hash: {self.topic_type_hash}',
                f'Endpoint type: {self.endpoint_type.name}',
                f'GID: {".".join(format(byte, "02x") for byte in self.endpoint_gid)}',
                'QoS profile:',
                f'  Reliability: {qos.reliability.name}',
                f'  History (Depth): {qos.history.name}{depth}',
                f'  Durability: {qos.durability.name}',
                f'  Lifespan: {qos.lifespan}',
                f'  Deadline: {qos.deadline}',
                f'  Liveliness: {qos.liveliness.name}',
                f'  Liveliness lease duration: {qos.liveliness_lease_duration}',
            ]
        )


reexport(__name__)
