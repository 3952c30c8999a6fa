"""rclpy.qos: the QoS classes that programs use. The rules are in goalwire.rules.qos."""

from __future__ import annotations

import warnings
from enum import Enum, IntEnum
from typing import Self, TypedDict, TypeVar, Unpack

from goalwire.errors import InvalidQoSProfileException
from goalwire.rules import qos as core
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    QoSPolicyEnum,
    ReliabilityPolicy,
)
from goalwire.rules.qos_compatibility import QoSCompatibility, check_compatible
from rclpy._reexports import reexport
from rclpy.duration import Duration

__all__ = [
    'DeadlineBestAvailable',
    'DurabilityPolicy',
    'Duration',
    'HistoryPolicy',
    'InvalidQoSProfileException',
    'LivelinessLeaseDurationeBestAvailable',
    'LivelinessPolicy',
    'QoSCompatibility',
    'QoSDurabilityPolicy',
    'QoSHistoryPolicy',
    'QoSLivelinessPolicy',
    'QoSPolicyEnum',
    'QoSPolicyKind',
    'QoSPresetProfiles',
    'QoSProfile',
    'QoSReliabilityPolicy',
    'ReliabilityPolicy',
    'qos_check_compatible',
    'qos_policy_name_from_kind',
    'qos_profile_action_status_default',
    'qos_profile_best_available',
    'qos_profile_default',
    'qos_profile_parameter_events',
    'qos_profile_parameters',
    'qos_profile_rosout_default',
    'qos_profile_sensor_data',
    'qos_profile_services_default',
    'qos_profile_system_default',
    'qos_profile_unknown',
]

QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy

PolicyT = TypeVar('PolicyT', bound=QoSPolicyEnum)


class QoSPolicyKind(IntEnum):
    """The kinds of QoS policies (rmw_qos_policy_kind_t)."""

    INVALID = 1 << 0
    DURABILITY = 1 << 1
    DEADLINE = 1 << 2
    LIVELINESS = 1 << 3
    RELIABILITY = 1 << 4
    HISTORY = 1 << 5
    LIFESPAN = 1 << 6
    DEPTH = 1 << 7
    LIVELINESS_LEASE_DURATION = 1 << 8
    AVOID_ROS_NAMESPACE_CONVENTIONS = 1 << 9


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """Return the name of a kind of QoS policy; raises ValueError for an unknown number."""
    return QoSPolicyKind(policy_kind).name


class _Policies(TypedDict, total=False):
    history: int
    depth: int
    reliability: int
    durability: int
    lifespan: Duration
    deadline: Duration
    liveliness: int
    liveliness_lease_duration: Duration
    avoid_ros_namespace_conventions: bool


def _refuse(policy: str, expected: str, value: object) -> AssertionError:
    return AssertionError(f'QoS {policy} must be {expected}, got {value!r}')


def _member(policy: str, kind: type[PolicyT], value: int) -> PolicyT:
    if not isinstance(value, int):
        raise _refuse(policy, f'a {kind.__name__}', value)
    return kind(value)


def _duration(policy: str, value: Duration) -> Duration:
    if not isinstance(value, Duration):
        raise _refuse(policy, 'an rclpy.duration.Duration', value)
    return value


class QoSProfile:
    """The quality of service of an endpoint.

    A depth or KEEP_ALL is required; the other policies have defaults. As in rclpy, setters raise
    AssertionError for a wrong type and ValueError for an unknown number.
    """

    __slots__ = [
        '_avoid_ros_namespace_conventions',
        '_deadline',
        '_depth',
        '_durability',
        '_history',
        '_lifespan',
        '_liveliness',
        '_liveliness_lease_duration',
        '_reliability',
    ]

    def __init__(self, **kwargs: Unpack[_Policies]) -> None:
        if any(f'_{name}' not in self.__slots__ for name in kwargs):
            raise AssertionError(f'Invalid arguments passed to constructor: {kwargs.keys()!r}')
        if 'history' not in kwargs and 'depth' not in kwargs:
            raise InvalidQoSProfileException('History and/or depth settings are required.')
        self.history = kwargs.get('history', HistoryPolicy.KEEP_LAST)
        if self.history is HistoryPolicy.KEEP_LAST and 'depth' not in kwargs:
            raise InvalidQoSProfileException('History set to KEEP_LAST without a depth setting.')
        # With KEEP_ALL the depth has no effect, but other nodes see the depth.
        self.depth = kwargs.get('depth', 10)
        self.reliability = kwargs.get('reliability', ReliabilityPolicy.RELIABLE)
        self.durability = kwargs.get('durability', DurabilityPolicy.VOLATILE)
        self.lifespan = kwargs.get('lifespan', Duration())
        self.deadline = kwargs.get('deadline', Duration())
        self.liveliness = kwargs.get('liveliness', LivelinessPolicy.SYSTEM_DEFAULT)
        self.liveliness_lease_duration = kwargs.get('liveliness_lease_duration', Duration())
        self.avoid_ros_namespace_conventions = kwargs.get('avoid_ros_namespace_conventions', False)

    @property
    def history(self) -> HistoryPolicy:
        """Whether a queue keeps the last `depth` messages or all."""
        return self._history

    @history.setter
    def history(self, value: int) -> None:
        self._history = _member('history', HistoryPolicy, value)

    @property
    def depth(self) -> int:
        """The length of the queue, in messages, under KEEP_LAST."""
        return self._depth

    @depth.setter
    def depth(self, value: int) -> None:
        if not isinstance(value, int):
            raise _refuse('depth', 'an int', value)
        if value < 0:
            raise ValueError('history depth must be greater than or equal to zero')
        if value == 0 and self.history is HistoryPolicy.KEEP_LAST:
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                'This will be interpreted as SYSTEM_DEFAULT',
                stacklevel=3,  # so that the warning shows the caller's line
            )
        self._depth = value

    @property
    def reliability(self) -> ReliabilityPolicy:
        """Whether lost messages are sent again."""
        return self._reliability

    @reliability.setter
    def reliability(self, value: int) -> None:
        self._reliability = _member('reliability', ReliabilityPolicy, value)

    @property
    def durability(self) -> DurabilityPolicy:
        """Whether late subscribers get earlier messages."""
        return self._durability

    @durability.setter
    def durability(self, value: int) -> None:
        self._durability = _member('durability', DurabilityPolicy, value)

    @property
    def lifespan(self) -> Duration:
        """The age after which a message expires; zero leaves it to the middleware."""
        return self._lifespan

    @lifespan.setter
    def lifespan(self, value: Duration) -> None:
        self._lifespan = _duration('lifespan', value)

    @property
    def deadline(self) -> Duration:
        """The longest time between two messages; zero leaves it to the middleware."""
        return self._deadline

    @deadline.setter
    def deadline(self, value: Duration) -> None:
        self._deadline = _duration('deadline', value)

    @property
    def liveliness(self) -> LivelinessPolicy:
        """The way in which a publisher asserts that it is alive."""
        return self._liveliness

    @liveliness.setter
    def liveliness(self, value: int) -> None:
        self._liveliness = _member('liveliness', LivelinessPolicy, value)

    @property
    def liveliness_lease_duration(self) -> Duration:
        """The time after which a silent publisher counts as lost; zero leaves it to the middleware."""
        return self._liveliness_lease_duration

    @liveliness_lease_duration.setter
    def liveliness_lease_duration(self, value: Duration) -> None:
        self._liveliness_lease_duration = _duration('liveliness_lease_duration', value)

    @property
    def avoid_ros_namespace_conventions(self) -> bool:
        """True if the wire uses the topic's name without ROS's prefix."""
        return self._avoid_ros_namespace_conventions

    @avoid_ros_namespace_conventions.setter
    def avoid_ros_namespace_conventions(self, value: bool) -> None:
        if not isinstance(value, bool):
            raise _refuse('avoid_ros_namespace_conventions', 'a bool', value)
        self._avoid_ros_namespace_conventions = value

    @classmethod
    def of(cls, qos_or_depth: QoSProfile | int) -> QoSProfile:
        """Return a given profile, or for an int a profile of that depth.

        Raises TypeError for anything else, ValueError for a depth below 0.
        """
        given: object = qos_or_depth
        if isinstance(given, QoSProfile):
            return given
        if isinstance(given, int):
            return cls(depth=given)
        shown = repr(given)
        hint = (
            'write 10, the number of messages that are kept (it is reliable then), or '
            'QoSProfile(depth=10, …), from rclpy.qos'
        )
        if callable(given):
            shown = getattr(given, '__name__', shown)
            hint = 'the callback stands before it: create_subscription(String, topic, callback, 10)'
        raise TypeError(f'Expected QoSProfile or int, but received {shown}: {hint}')

    def to_core(self) -> QoS:
        """Return the profile in the frozen form that the layers below rclpy use."""
        return QoS(
            depth=self.depth,
            history=self.history,
            reliability=self.reliability,
            durability=self.durability,
            deadline_ns=self.deadline.nanoseconds,
            lifespan_ns=self.lifespan.nanoseconds,
            liveliness=self.liveliness,
            lease_ns=self.liveliness_lease_duration.nanoseconds,
            avoid_ros_namespace_conventions=self.avoid_ros_namespace_conventions,
        )

    @classmethod
    def from_core(cls, qos: QoS) -> Self:
        """Return a mutable profile with the values of a frozen profile, for example one from discovery."""
        profile = cls(
            history=HistoryPolicy.KEEP_ALL,
            reliability=qos.reliability,
            durability=qos.durability,
            deadline=Duration(nanoseconds=qos.deadline_ns),
            lifespan=Duration(nanoseconds=qos.lifespan_ns),
            liveliness=qos.liveliness,
            liveliness_lease_duration=Duration(nanoseconds=qos.lease_ns),
            avoid_ros_namespace_conventions=qos.avoid_ros_namespace_conventions,
        )
        # Not checked: a peer may have KEEP_LAST with depth 0, which is not an error of this program.
        profile._history, profile._depth = qos.history, qos.depth
        return profile

    def get_c_qos_profile(self) -> QoS:
        """Return the profile in its frozen form, which stands in for rclpy's C profile."""
        return self.to_core()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QoSProfile):
            return False
        return all(getattr(self, slot) == getattr(other, slot) for slot in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        values = ', '.join(f'{name}={getattr(self, name)}' for name in _IN_ORDER)
        return f'{type(self).__name__}({values})'


_IN_ORDER = (
    'history',
    'depth',
    'reliability',
    'durability',
    'lifespan',
    'deadline',
    'liveliness',
    'liveliness_lease_duration',
    'avoid_ros_namespace_conventions',
)
"""The policies in ROS 2's order."""

DeadlineBestAvailable = Duration(nanoseconds=core.BEST_AVAILABLE_NS)
LivelinessLeaseDurationeBestAvailable = Duration(nanoseconds=core.BEST_AVAILABLE_NS)

qos_profile_unknown = QoSProfile.from_core(core.UNKNOWN)
qos_profile_default = QoSProfile.from_core(core.DEFAULT)
qos_profile_system_default = QoSProfile.from_core(core.SYSTEM_DEFAULT)
qos_profile_sensor_data = QoSProfile.from_core(core.SENSOR_DATA)
qos_profile_services_default = QoSProfile.from_core(core.SERVICES_DEFAULT)
qos_profile_parameters = QoSProfile.from_core(core.PARAMETERS)
qos_profile_parameter_events = QoSProfile.from_core(core.PARAMETER_EVENTS)
qos_profile_rosout_default = QoSProfile.from_core(core.ROSOUT)
qos_profile_best_available = QoSProfile.from_core(core.BEST_AVAILABLE)
qos_profile_action_status_default = QoSProfile.from_core(core.ACTION_STATUS_DEFAULT)


class QoSPresetProfiles(Enum):
    """ROS 2's predefined profiles. As in rclpy, equal profiles are one enum member with two names."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available
    ROSOUT_DEFAULT = qos_profile_rosout_default

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the profiles' names in lower case, as command lines spell them."""
        return [name.lower() for name in cls.__members__]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Return the profile with a short key; raises KeyError for an unknown key."""
        profile: QoSProfile = cls[name.upper()].value
        return profile


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Return whether a publisher and a subscription with these profiles match on DDS, and why not."""
    return check_compatible(publisher_qos.to_core(), subscription_qos.to_core())


reexport(__name__)
