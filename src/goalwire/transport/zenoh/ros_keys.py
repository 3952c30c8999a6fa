"""The keys of data, the liveliness tokens of nodes and endpoints, and their gids.

    data      <domain>/<name>/<dds type>/<hash>, one formula for topics and services
    node      @ros2_lv/<domain>/<session>/<node id>/<node id>/NN/<enclave>/<namespace>/<name>
    endpoint  @ros2_lv/<domain>/<session>/<node id>/<id>/<MP|MS|SS|SC>/<enclave>/<namespace>/<name>
              /<topic or service>/<dds type>/<hash>/<qos>[/<backends>]
    qos       <reliability>:<durability>:<history>,<depth>:<deadline s>,<ns>:<lifespan s>,<ns>
              :<liveliness>,<lease s>,<ns>, every policy that is not rmw_zenoh's default, in decimal

Slashes within a chunk are written as '%'. The spelling of types is that of ROS 2 over DDS. Source:
rmw_zenoh_cpp docs/design.md, src/detail/liveliness_utils.cpp, src/detail/qos.cpp.
"""

from __future__ import annotations

from enum import IntEnum
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from xxhash import xxh3_128_intdigest

from goalwire.errors import LocalError, RemoteError, TransportError
from goalwire.patterns import Pattern
from goalwire.rules.qos import (
    INFINITE_NS,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName
from goalwire.transport.graph_names import check_names

if TYPE_CHECKING:
    from goalwire.rules.names.robots import RobotView

GRAPH_SPACE = '@ros2_lv'
"""The first chunk of every liveliness token; since it begins with `@`, `**` does not match it."""
CPU_BUFFERS = '_buf_cpu'
"""The last chunk of a second key that ROS 2 Lyrical and later use for types with buffers."""

_FORBIDDEN = Pattern(r'//|[*#?$ ]')


@lru_cache(maxsize=256)
def dds_type(type_name: str) -> str:
    """Return 'std_msgs::msg::dds_::String_' for 'std_msgs/msg/String'."""
    *namespace, name = type_name.split('/')
    return '::'.join([*namespace, 'dds_', f'{name}_'])


@lru_cache(maxsize=256)
def ros_type(dds_name: str) -> str:
    """Return 'std_msgs/msg/String' for its DDS spelling; return any other text unchanged."""
    namespace, found, name = dds_name.rpartition('::dds_::')
    if not found or not name.endswith('_'):
        return dds_name
    return f'{namespace.replace("::", "/")}/{name[:-1]}'


def data_key(domain_id: int, name: str, type_name: str, type_hash: str) -> str:
    """Return the key that publishers and subscriptions, or clients and servers, share.

    Raises TransportError for a name that Zenoh cannot carry.
    """
    path = name.removeprefix('/').removesuffix('/')
    key = f'{domain_id}/{path}/{dds_type(type_name)}/{type_hash}'
    if _FORBIDDEN.search(key):
        raise TransportError(
            f"'{name}' of type '{type_name}' (hash '{type_hash}') cannot travel over Zenoh: "
            f"empty parts and '*', '#', '?', '$' and blanks are not allowed; choose another name"
        )
    return key


def graph_key(domain_id: int) -> str:
    """Return the expression that matches every liveliness token of a domain."""
    return f'{GRAPH_SPACE}/{domain_id}/**'


def own_graph_key(domain_id: int, session: str) -> str:
    """Return the expression that matches the tokens of one session."""
    return f'{GRAPH_SPACE}/{domain_id}/{session}/**'


class RobotKeys(NamedTuple):
    """The key expressions of everything that robots have whose names match some patterns."""

    tokens: tuple[str, ...]
    """Liveliness tokens of nodes and endpoints, and of endpoints with history."""
    entities: tuple[str, ...]
    """Subscribers and queryables: topics, services and actions."""

    @property
    def graph(self) -> tuple[str, ...]:
        """The tokens of nodes and endpoints alone."""
        return tuple(key for key in self.tokens if key.startswith(GRAPH_SPACE))


def robot_keys(domain_id: int, view: RobotView) -> RobotKeys:
    """Return the key expressions of a view of some robots."""
    codes = _CODES[EndpointKind.NODE] if view.nodes_only else '*'
    tokens: list[str] = []
    entities: list[str] = []
    for pattern in view.patterns:
        chunk = pattern.replace('*', '$*')
        head = f'{GRAPH_SPACE}/{domain_id}/*/*/*/{codes}/*'
        tokens += [f'{head}/%{chunk}/**', f'{head}/%{chunk}%$*/**']
        names = f'{domain_id}/{"*" if pattern == "*" else chunk}/**'
        if not view.nodes_only:
            tokens.append(f'{names}/@adv/**')
            entities += [names, f'{names}/@adv/**']
    return RobotKeys(tuple(tokens), tuple(entities))


DEFAULT_DEPTH = 42
"""The depth that replaces depth 0."""

_DIGITS = 20
"""The number of digits of the largest 64-bit number."""

_SECOND = 1_000_000_000
_INFINITE = divmod(INFINITE_NS, _SECOND)

P = TypeVar('P', bound=IntEnum)


def actual_depth(qos: QoS) -> int:
    """Return how many messages an endpoint with this QoS keeps."""
    return qos.depth or DEFAULT_DEPTH


@lru_cache(maxsize=256)  # cached: all seven built-in services of a node have the same QoS
def encode_qos(qos: QoS) -> str:
    """Return a token's QoS chunk; raises LocalError for a policy that is UNKNOWN."""
    for name in ('reliability', 'durability', 'history', 'liveliness'):
        if getattr(qos, name).name == 'UNKNOWN':
            raise LocalError(f'QoS: {name} is UNKNOWN, which no endpoint can have; choose a policy')
    depth = actual_depth(qos)
    return ':'.join(
        (
            _policy(qos.reliability, ReliabilityPolicy.RELIABLE),
            _policy(qos.durability, DurabilityPolicy.VOLATILE),
            f'{_policy(qos.history, HistoryPolicy.KEEP_LAST)},{"" if depth == DEFAULT_DEPTH else depth}',
            _duration(qos.deadline_ns),
            _duration(qos.lifespan_ns),
            f'{_policy(qos.liveliness, LivelinessPolicy.AUTOMATIC)},{_duration(qos.lease_ns)}',
        )
    )


def decimal(text: str) -> int:
    """Read a number in a token; raises ValueError for other text or more digits than rmw_zenoh writes."""
    if not (text.isascii() and text.isdigit() and len(text) <= _DIGITS):
        raise ValueError(f"'{text}' is not a decimal number of at most {_DIGITS} digits")
    return int(text)


def _policy(value: IntEnum, default: IntEnum) -> str:
    is_default = value in (default, 0)  # 0 is SYSTEM_DEFAULT in every policy
    return '' if is_default else str(value.value)


def _duration(nanoseconds: int) -> str:
    """Return '<seconds>,<nanoseconds>'. A part is empty if it equals that of infinity; 0 means infinity."""
    halves = divmod(nanoseconds or INFINITE_NS, _SECOND)
    return ','.join('' if half == whole else str(half) for half, whole in zip(halves, _INFINITE, strict=True))


@lru_cache(maxsize=256)
def decode_qos(text: str) -> QoS:
    """Read a token's QoS chunk; raises RemoteError if it does not follow the grammar."""
    try:
        reliability, durability, history, deadline, lifespan, liveliness = text.split(':')
        history_kind, depth = history.split(',')
        liveliness_kind, lease = liveliness.split(',', 1)
        return QoS(
            depth=_number(depth, DEFAULT_DEPTH),
            history=_member(HistoryPolicy, history_kind, HistoryPolicy.KEEP_LAST),
            reliability=_member(ReliabilityPolicy, reliability, ReliabilityPolicy.RELIABLE),
            durability=_member(DurabilityPolicy, durability, DurabilityPolicy.VOLATILE),
            deadline_ns=_nanoseconds(deadline),
            lifespan_ns=_nanoseconds(lifespan),
            liveliness=_member(LivelinessPolicy, liveliness_kind, LivelinessPolicy.AUTOMATIC),
            lease_ns=_nanoseconds(lease),
        )
    except ValueError as error:
        raise RemoteError(f"QoS '{text}' of a liveliness token: {error}") from None


def _number(text: str, default: int) -> int:
    return decimal(text) if text else default


def _member(kind: type[P], text: str, default: P) -> P:
    return kind(_number(text, default.value))


def _nanoseconds(text: str) -> int:
    halves = zip(text.split(','), _INFINITE, strict=True)
    seconds, nanoseconds = (_number(half, whole) for half, whole in halves)
    return min(seconds * _SECOND + nanoseconds, INFINITE_NS)


_CODES = {
    EndpointKind.NODE: 'NN',
    EndpointKind.PUBLISHER: 'MP',
    EndpointKind.SUBSCRIPTION: 'MS',
    EndpointKind.SERVICE: 'SS',
    EndpointKind.CLIENT: 'SC',
}
_KINDS = {code: kind for kind, code in _CODES.items()}
_NODE_CHUNKS = 9
_ENDPOINT_CHUNKS = 13
_CPU_ONLY = 'backends:cpu:'


def encode_node(domain_id: int, session: str, node_id: int, node: NodeName) -> str:
    """Return a node's token. It has the node's id twice, as node and as entity."""
    return _head(domain_id, session, node_id, node_id, EndpointKind.NODE, node)


def encode_endpoint(
    domain_id: int, session: str, node_id: int, entity_id: int, node: NodeName, endpoint: Endpoint
) -> str:
    """Return an endpoint's token; raises LocalError for a QoS that no endpoint can have."""
    chunks = [
        _head(domain_id, session, node_id, entity_id, endpoint.kind, node),
        _mangle(endpoint.name),
        dds_type(endpoint.type_name),
        endpoint.type_hash,
        encode_qos(endpoint.qos),
    ]
    if uses_cpu_channel(endpoint):
        chunks.append(_CPU_ONLY)
    return '/'.join(chunks)


def uses_cpu_channel(endpoint: Endpoint) -> bool:
    """Return whether a subscription must announce that it takes plain memory; else Lyrical ignores it."""
    return (
        endpoint.kind is EndpointKind.SUBSCRIPTION
        and endpoint.has_buffers
        and not endpoint.qos.is_transient_local
    )


def _head(
    domain_id: int, session: str, node_id: int, entity_id: int, kind: EndpointKind, node: NodeName
) -> str:
    return f'{GRAPH_SPACE}/{domain_id}/{session}/{node_id}/{entity_id}/{_CODES[kind]}/{_names(node)}'


@lru_cache(maxsize=64)  # cached: every endpoint of a node needs the same names
def _names(node: NodeName) -> str:
    names = '/'.join(_mangle(text) for text in (node.enclave or '/', node.namespace or '/', node.name))
    if not _is_carried(names):
        raise TransportError(
            f"node '{node.qualified}' (enclave '{node.enclave}') has a name Zenoh cannot carry"
        )
    return names


def _mangle(text: str) -> str:
    return text.replace('/', '%')


def _demangle(text: str) -> str:
    return text.replace('%', '/')


def _is_carried(key: str) -> bool:
    return '//' not in key and not key.endswith('/') and not any(sign in key for sign in '*#?$')


def gid_of(token: str) -> bytes:
    """Return the 16 bytes that name a token's owner: XXH3-128 of the token, little endian.

    For an endpoint only the chunks of Jazzy count, so without `backends`. Lyrical includes `backends`, but
    nobody compares the gids of subscriptions.
    """
    chunks = token.split('/', _ENDPOINT_CHUNKS)
    if len(chunks) > _ENDPOINT_CHUNKS:
        token = '/'.join(chunks[:_ENDPOINT_CHUNKS])
    return xxh3_128_intdigest(token.encode()).to_bytes(16, 'little')


def own_entity(token: str, session: str, node_id: int, node: NodeName, endpoint: Endpoint) -> GraphEntity:
    """Return the entity of this session's own endpoint, as `parse` would read it from the token."""
    return GraphEntity(
        endpoint.kind,
        session,
        node_id,
        node,
        name=endpoint.name,
        type_name=endpoint.type_name,
        type_hash=endpoint.type_hash,
        qos=decode_qos(encode_qos(endpoint.qos)),
        gid=gid_of(token),
    )


def parse(token: str) -> GraphEntity:
    """Read a token; raises RemoteError, naming the chunk, for one that breaks the grammar."""
    chunks = token.split('/')
    check_names('liveliness token', *chunks)
    if len(chunks) < _NODE_CHUNKS or chunks[0] != GRAPH_SPACE or '' in chunks:
        raise RemoteError(f"liveliness token '{token}': expected {_NODE_CHUNKS} or more chunks, none empty")
    _, domain, session, node_id, entity_id, code, enclave, namespace, name = chunks[:_NODE_CHUNKS]
    try:
        _, node_number, _ = map(decimal, (domain, node_id, entity_id))
    except ValueError as error:
        raise RemoteError(f"liveliness token '{token}': {error}") from None
    kind = _KINDS.get(code)
    if kind is None:
        raise RemoteError(f"liveliness token '{token}': '{code}' is none of {', '.join(_KINDS)}")
    node = NodeName(_demangle(name), _demangle(namespace), _demangle(enclave))
    if kind is EndpointKind.NODE:
        return GraphEntity(kind, session, node_number, node, gid=gid_of(token))
    if len(chunks) < _ENDPOINT_CHUNKS:
        raise RemoteError(f"liveliness token '{token}': an endpoint's has {_ENDPOINT_CHUNKS} chunks or more")
    topic, type_text, type_hash, qos = chunks[_NODE_CHUNKS:_ENDPOINT_CHUNKS]
    return GraphEntity(
        kind,
        session,
        node_number,
        node,
        name=_demangle(topic),
        type_name=ros_type(_demangle(type_text)),
        type_hash=_demangle(type_hash),
        qos=decode_qos(qos),
        gid=gid_of(token),
    )
