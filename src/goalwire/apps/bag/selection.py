"""The choice of topics, services and actions by the flags of `ros2 bag record` and `play`.

The rules are rosbag2's (rosbag2_transport, topic_filter.cpp): excluded names are always left out, and other
names are included if any flag names them. A service is recognised by the topic of its events, an action by
its topics and services.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from goalwire.records import record
from goalwire.rosbag2.model import SERVICE_EVENT

if TYPE_CHECKING:
    from goalwire.transport.contract import GraphEntity

_ACTION = '/_action/'
_ACTION_TOPICS = ('feedback', 'status')


def action_of(topic: str) -> str:
    """Return the action to which a topic, or an event topic's service, belongs; '' for other topics."""
    action, found, part = topic.partition(_ACTION)
    is_part = part in _ACTION_TOPICS or part.endswith(SERVICE_EVENT)
    return action if found and is_part else ''


def service_of(topic: str) -> str:
    """Return the service whose events a topic carries; '' for other topics and for actions' services."""
    return topic.removesuffix(SERVICE_EVENT) if topic.endswith(SERVICE_EVENT) and not action_of(topic) else ''


def is_hidden(name: str) -> bool:
    """Return whether a part of a name begins with an underscore: ROS 2 shows such names only on request."""
    return any(part.startswith('_') for part in name.split('/'))


@record
class Names:
    """The chosen names of one kind: all, some or none, without the excluded names."""

    all: bool = False
    some: frozenset[str] = frozenset()
    out: frozenset[str] = frozenset()

    def has(self, name: str) -> bool:
        """Return whether a name is chosen."""
        return name not in self.out and (self.all or name in self.some)


NONE = Names()


@record
class Selection:
    """The chosen topics, services and actions, by full names.

    A regular expression may match any part of a name.
    """

    topics: Names = NONE
    services: Names = NONE
    actions: Names = NONE
    types: frozenset[str] = frozenset()
    """Topics of these types are chosen."""
    types_out: frozenset[str] = frozenset()
    regex: str = ''
    """Topics, services and actions that match this expression are chosen."""
    regex_out: str = ''
    hidden: bool = False
    """True to include hidden topics."""

    def wants(self, topic: str, type_name: str) -> bool:
        """Return whether a topic is to be recorded, or played."""
        action, service = action_of(topic), service_of(topic)
        if action:
            return self._has(action, self.actions)
        if service:
            return self._has(service, self.services)
        if type_name in self.types_out or not self._has(topic, self.topics, type_name):
            return False
        return topic in self.topics.some or self.hidden or not is_hidden(topic)

    def _has(self, name: str, names: Names, type_name: str = '') -> bool:
        if name in names.out or (self.regex_out and re.search(self.regex_out, name)):
            return False
        if names.has(name) or type_name in self.types:
            return True
        return bool(self.regex) and re.search(self.regex, name) is not None


_OF_EVERY_NODE = ('rcl_interfaces/srv/', 'type_description_interfaces/srv/')
"""Types of the services that every node has. Their calls are recorded only if the user names them."""


def wants_calls(selection: Selection, server: GraphEntity) -> bool:
    """Return whether the calls of a server, or of a client, are to be recorded."""
    name = server.name
    if server.type_name.startswith(_OF_EVERY_NODE) and name not in selection.services.some:
        return False
    return selection.wants(name + SERVICE_EVENT, f'{server.type_name}_Event')
