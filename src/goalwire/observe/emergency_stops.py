"""The topics and services of robots' emergency stops, known by their names and types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from goalwire.errors import peer_text
from goalwire.records import record

BOOL = 'std_msgs/msg/Bool'
DIAGNOSTIC_STATUS = 'diagnostic_msgs/msg/DiagnosticStatus'
_STOP_TYPES = {'std_srvs/srv/Trigger', 'std_srvs/srv/SetBool', 'std_srvs/srv/Empty'}
_STOP_NAMES = ('estop', 'e_stop', 'emergency_stop')
_RELEASE_NAMES = ('release', 'reset', 'clear', 'resume')
_STATE_ENDS = ('ped', '_state', '_active')
_ERROR = 2
_MOST_TEXT = 300


@record
class StopService:
    """A service that stops a robot."""

    name: str
    type_name: str

    @property
    def values(self) -> dict[str, bool]:
        """The fields of the request that stops the robot."""
        return {'data': True} if self.can_release else {}

    @property
    def can_release(self) -> bool:
        """True if a call of the same service with false releases the robot."""
        return self.type_name.endswith('SetBool')


def stop_services(services: Sequence[tuple[str, list[str]]]) -> list[StopService]:
    """Return the emergency stops among services: types of std_srvs, with estop, e_stop or emergency_stop in
    the name.
    """
    return [
        StopService(name, types[0])
        for name, types in services
        if types[0] in _STOP_TYPES
        and any(word in name.lower() for word in _STOP_NAMES)
        and not any(word in name.lower().rpartition('/')[2] for word in _RELEASE_NAMES)
    ]


def says_state(topic: str, type_name: str) -> bool:
    """Return True if a topic reports the state of an emergency stop.

    A topic of Bool does so if its name is emergency_stopped, or a stop service's name with _state or _active;
    true means stopped. A topic of DiagnosticStatus does so if its name is a stop service's name with _status.
    """
    last = topic.lower().rpartition('/')[2]
    ends = {BOOL: _STATE_ENDS, DIAGNOSTIC_STATUS: ('_status',)}.get(type_name, ())
    return any(last == name + end for name in _STOP_NAMES for end in ends)


@record
class Word:
    """A publisher's statement about the emergency stop."""

    node: str
    topic: str
    stopped: bool
    reason: str = ''
    by: str = ''
    """The name of the client that has stopped the robot; '' if it is unknown."""
    is_switch: bool = False
    """True if the node also serves the emergency stop."""


def word_of(message: Any, node: str, topic: str, *, is_switch: bool) -> Word:
    """Return what a Bool or a DiagnosticStatus says about the emergency stop.

    A DiagnosticStatus may have the values `stopped` ('true' or 'false') and `by`. Without `stopped`, a level
    of ERROR or worse means stopped. Its `message` is the reason.
    """
    if hasattr(message, 'data'):
        return Word(node, topic, bool(message.data), is_switch=is_switch)
    values = {each.key: each.value for each in message.values}
    level = message.level[0] if isinstance(message.level, bytes) else int(message.level)
    stopped = values['stopped'] == 'true' if 'stopped' in values else level >= _ERROR
    reason, by = (peer_text(text, _MOST_TEXT) for text in (message.message, values.get('by', '')))
    return Word(node, topic, stopped, reason if stopped else '', by if stopped else '', is_switch)
