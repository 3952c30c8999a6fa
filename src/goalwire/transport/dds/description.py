"""How an endpoint of ROS 2 describes itself on DDS: the names of its topic and type, its QoS, its USER_DATA.

Topics have a prefix for their kind, types have 'dds_' in the middle. USER_DATA holds 'key=value;' pairs, with
the ids that tie a service's ends together. Source: rmw_cyclonedds_cpp src/demangle.cpp, rmw_node.cpp
(create_readwrite_qos); rmw_dds_common src/qos.cpp.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref, c_int32, c_int64, c_size_t, c_void_p, string_at
from enum import Enum
from typing import NamedTuple

from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.dds.abi import INFINITY, Library

DISCOVERY_TOPIC = 'ros_discovery_info'
DISCOVERY_TYPE = 'rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_'

_MARK = '::dds_::'


class Role(Enum):
    """The kinds of DDS topics."""

    TOPIC = 'rt'
    REQUEST = 'rq'
    REPLY = 'rr'


class TopicName(NamedTuple):
    """A ROS 2 name and what its DDS topic carries."""

    role: Role
    name: str


_SUFFIXES = {Role.TOPIC: '', Role.REQUEST: 'Request', Role.REPLY: 'Reply'}
_TYPE_SUFFIXES = {Role.TOPIC: '_', Role.REQUEST: '_Request_', Role.REPLY: '_Response_'}
_ROLES = {role.value: role for role in Role}


def dds_topic(role: Role, name: str, *, verbatim: bool = False) -> str:
    """Return the DDS topic of a fully-qualified name; `verbatim` leaves the prefix out."""
    return f'{"" if verbatim else role.value}{name}{_SUFFIXES[role]}'


def ros_topic(topic: str) -> TopicName | None:
    """Return what a DDS topic is in ROS 2; None for one that is not ROS 2's.

    A topic without ROS 2's prefixes counts, by its own name, where that is one of ROS 2.
    """
    prefix, slash, rest = topic.partition('/')
    if not slash:
        return None
    if not prefix:
        return TopicName(Role.TOPIC, topic)
    role = _ROLES.get(prefix)
    if role is None or not rest or not topic.endswith(_SUFFIXES[role]):
        return None
    return TopicName(role, f'/{rest}'.removesuffix(_SUFFIXES[role]))


def dds_type(role: Role, type_name: str) -> str:
    """Return the DDS type of 'pkg/msg/Name' or, for what a service sends, of 'pkg/srv/Name'."""
    namespace, _, name = type_name.rpartition('/')
    return f'{namespace.replace("/", "::")}{_MARK}{name}{_TYPE_SUFFIXES[role]}'


def ros_type(role: Role, type_name: str) -> str:
    """Return the ROS 2 type of a DDS type; a type that is not ROS 2's keeps its name."""
    namespace, mark, name = type_name.partition(_MARK)
    suffix = _TYPE_SUFFIXES[role]
    if not mark or not name.endswith(suffix):
        return type_name
    return f'{namespace.replace("::", "/")}/{name.removesuffix(suffix)}'


GUID_PREFIX_SIZE = 12
REFUSALS = 'goalwire'
"""The key of a client that takes refusals (service_header.py); ROS 2 skips what it does not know."""


class EndpointData(NamedTuple):
    """The facts that an endpoint announces of itself; '' for those that it does not."""

    type_hash: str = ''
    service_id: str = ''
    client_id: str = ''
    takes_refusals: bool = False
    """Whether a client knows what service_header.py describes."""


def encode_participant(enclave: str) -> bytes:
    """Return a participant's user data."""
    return f'enclave={enclave};'.encode()


def enclave_of(data: bytes) -> str:
    """Return the enclave that a participant names, '' if it names none."""
    return _pairs(data).get('enclave', '')


def encode_endpoint(data: EndpointData) -> bytes:
    """Return an endpoint's user data, in ROS 2's order, goalwire's own key last."""
    pairs = (
        ('serviceid', data.service_id),
        ('clientid', data.client_id),
        ('typehash', data.type_hash),
        (REFUSALS, '1' if data.takes_refusals else ''),
    )
    return ''.join(f'{key}={value};' for key, value in pairs if value).encode()


def decode_endpoint(data: bytes) -> EndpointData:
    """Read an endpoint's user data; what cannot be read counts as not said."""
    pairs = _pairs(data)
    return EndpointData(
        pairs.get('typehash', ''), pairs.get('serviceid', ''), pairs.get('clientid', ''), REFUSALS in pairs
    )


def _pairs(data: bytes) -> dict[str, str]:
    fields = (field.partition('=') for field in data.decode(errors='replace').split(';'))
    return {key: value for key, is_pair, value in fields if is_pair and value.isprintable()}


def service_id(participant: bytes, number: int) -> str:
    """Return the id that the two ends of one client or server share: only its equality matters."""
    raw = participant[:GUID_PREFIX_SIZE] + number.to_bytes(4, 'big')
    first, *rest = raw
    return '.'.join([f'{first:2x}', *(f'{byte:x}' for byte in rest)])


_KEEP_LAST, _KEEP_ALL = 0, 1
_BEST_EFFORT, _RELIABLE = 0, 1
_VOLATILE, _TRANSIENT_LOCAL = 0, 1
_AUTOMATIC, _MANUAL_BY_TOPIC = 0, 2
_IGNORE_PARTICIPANT = 1
_UNLIMITED = -1
_LARGEST_DEPTH = 2**31 - 1

_DURABILITIES = {_VOLATILE: DurabilityPolicy.VOLATILE, _TRANSIENT_LOCAL: DurabilityPolicy.TRANSIENT_LOCAL}
_LIVELINESSES = {
    _AUTOMATIC: LivelinessPolicy.AUTOMATIC,
    _MANUAL_BY_TOPIC: LivelinessPolicy.MANUAL_BY_TOPIC,
}
_RELIABILITIES = {_BEST_EFFORT: ReliabilityPolicy.BEST_EFFORT, _RELIABLE: ReliabilityPolicy.RELIABLE}


@contextmanager
def endpoint_qos(
    library: Library,
    qos: QoS,
    user_data: bytes,
    *,
    ignore_local: bool = False,
    blocking_ns: int = INFINITY,
) -> Iterator[int]:
    """Make a dds_qos_t for one reader or writer; it lives as long as the block.

    A reliable write waits for room up to `blocking_ns`.
    """
    made = library.dds_create_qos()
    try:
        _fill(library, made, qos, blocking_ns)
        library.dds_qset_userdata(made, user_data, len(user_data))
        library.dds_qset_writer_data_lifecycle(made, False)
        if ignore_local:
            library.dds_qset_ignorelocal(made, _IGNORE_PARTICIPANT)
        yield made
    finally:
        library.dds_delete_qos(made)


def _fill(library: Library, made: int, qos: QoS, blocking_ns: int) -> None:
    keep = _KEEP_ALL if qos.keeps_all else _KEEP_LAST
    depth = _UNLIMITED if qos.keeps_all else min(qos.depth or 1, _LARGEST_DEPTH)
    library.dds_qset_history(made, keep, depth)
    if qos.is_reliable:
        library.dds_qset_reliability(made, _RELIABLE, blocking_ns)
    else:
        library.dds_qset_reliability(made, _BEST_EFFORT, 0)
    if qos.is_transient_local:
        library.dds_qset_durability(made, _TRANSIENT_LOCAL)
        limits = (_UNLIMITED, _UNLIMITED, _UNLIMITED)
        library.dds_qset_durability_service(made, 0, keep, depth, *limits)
    else:
        library.dds_qset_durability(made, _VOLATILE)
    if qos.deadline_ns:
        library.dds_qset_deadline(made, qos.deadline_ns)
    if qos.lifespan_ns:
        library.dds_qset_lifespan(made, qos.lifespan_ns)
    manual = qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
    library.dds_qset_liveliness(made, _MANUAL_BY_TOPIC if manual else _AUTOMATIC, qos.lease_ns or INFINITY)


def read_qos(library: Library, made: int, *, verbatim: bool = False) -> QoS:
    """Return what an endpoint's dds_qos_t says; what it leaves open is UNKNOWN, or DDS's default."""
    kind, depth, duration = c_int32(), c_int32(), c_int64()
    history, kept = HistoryPolicy.UNKNOWN, 0
    if library.dds_qget_history(made, byref(kind), byref(depth)):
        keeps_all = kind.value == _KEEP_ALL
        history = HistoryPolicy.KEEP_ALL if keeps_all else HistoryPolicy.KEEP_LAST
        kept = 0 if keeps_all else depth.value
    reliability = ReliabilityPolicy.UNKNOWN
    if library.dds_qget_reliability(made, byref(kind), byref(duration)):
        reliability = _RELIABILITIES.get(kind.value, reliability)
    durability = DurabilityPolicy.UNKNOWN
    if library.dds_qget_durability(made, byref(kind)):
        durability = _DURABILITIES.get(kind.value, durability)
    deadline = duration.value if library.dds_qget_deadline(made, byref(duration)) else INFINITY
    lifespan = duration.value if library.dds_qget_lifespan(made, byref(duration)) else INFINITY
    liveliness, lease = LivelinessPolicy.UNKNOWN, INFINITY
    if library.dds_qget_liveliness(made, byref(kind), byref(duration)):
        liveliness, lease = _LIVELINESSES.get(kind.value, liveliness), duration.value
    return QoS(kept, history, reliability, durability, deadline, lifespan, liveliness, lease, verbatim)


_PORT = re.compile(r':([0-9]+)(?=@|,|$)')


def read_ports(library: Library, made: int, host: str) -> frozenset[int] | None:
    """Return the UDP ports at which a participant listens for discovery, if it is on `host`.

    None if it does not tell, as an older Cyclone DDS, or one of another vendor.
    """
    addresses = _read_property(library, made, b'__NetworkAddresses')
    if addresses is None:
        return None
    if _read_property(library, made, b'__Hostname') != host:
        return frozenset()
    return frozenset(map(int, _PORT.findall(addresses)))


def _read_property(library: Library, made: int, name: bytes) -> str | None:
    value = c_void_p()
    if not library.dds_qget_prop(made, name, byref(value)) or not value.value:
        return None
    try:
        return string_at(value.value).decode(errors='replace')
    finally:
        library.dds_free(value)


def read_user_data(library: Library, made: int) -> bytes:
    """Return the user data in a dds_qos_t, b'' if there is none."""
    value, size = c_void_p(), c_size_t()
    if not library.dds_qget_userdata(made, byref(value), byref(size)) or not value.value:
        return b''
    try:
        return string_at(value.value, size.value)
    finally:
        library.dds_free(value)
