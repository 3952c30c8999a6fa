"""How an endpoint of ROS 2 describes itself on DDS: the names of its topic and type, its QoS, its USER_DATA.

Topics have a prefix for their kind, types have 'dds_' in the middle. USER_DATA holds 'key=value;' pairs, with
the ids that tie a service's ends together. Source: rmw_cyclonedds_cpp src/demangle.cpp, rmw_node.cpp
(create_readwrite_qos); rmw_dds_common src/qos.cpp.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

DISCOVERY_TOPIC = 'ros_discovery_info'
DISCOVERY_TYPE = 'rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_'

_MARK = '::dds_::'


class Role(Enum):
    """The kinds of DDS topics: messages, requests and replies."""

    TOPIC = 'rt'
    REQUEST = 'rq'
    REPLY = 'rr'


class TopicName(NamedTuple):
    """A ROS 2 name, and the role of its DDS topic."""

    role: Role
    name: str


_SUFFIXES = {Role.TOPIC: '', Role.REQUEST: 'Request', Role.REPLY: 'Reply'}
_TYPE_SUFFIXES = {Role.TOPIC: '_', Role.REQUEST: '_Request_', Role.REPLY: '_Response_'}
_ROLES = {role.value: role for role in Role}


def dds_topic(role: Role, name: str, *, verbatim: bool = False) -> str:
    """Return the DDS topic of a fully-qualified name; `verbatim` leaves the prefix out."""
    return f'{"" if verbatim else role.value}{name}{_SUFFIXES[role]}'


def ros_topic(topic: str) -> TopicName | None:
    """Return the ROS 2 name of a DDS topic; None for one that is not ROS 2's.

    A topic without ROS 2's prefixes keeps its name, if that begins with a slash.
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
    """Return the DDS type of 'pkg/msg/Name' or, for a service's messages, of 'pkg/srv/Name'."""
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
"""The USER_DATA key of clients that understand refusals (service_header.py); ROS 2 skips unknown keys."""


class EndpointData(NamedTuple):
    """The data that an endpoint announces of itself; '' for missing values."""

    type_hash: str = ''
    service_id: str = ''
    client_id: str = ''
    takes_refusals: bool = False
    """True if a client understands the refusals of service_header.py."""


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
    """Read an endpoint's user data; unreadable values count as missing."""
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
