"""ROS 2's names on DDS: topics with a prefix for their kind, types with 'dds_' in the middle.

Source: rmw_cyclonedds_cpp src/demangle.cpp, rmw_node.cpp.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

DISCOVERY_TOPIC = 'ros_discovery_info'
DISCOVERY_TYPE = 'rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_'

_MARK = '::dds_::'


class Role(Enum):
    """What a DDS topic carries."""

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
