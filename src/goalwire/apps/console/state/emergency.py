"""The emergency stop of one robot: its servers, and the robot's reports.

What the console has pressed says nothing here: a robot is stopped if it says so. The rules:

- Each publisher has a voice, and keeps to its last word. If one of them says "stopped", the robot is stopped.
- A voice that repeated its word and falls silent makes the state unknown, and so does one that has gone.
  It stays so until the same node speaks again, or a node that serves the emergency stop.
- A robot that never said anything is untold: it may have a service and no topic for its state.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from enum import Enum
from typing import Any

from goalwire.errors import peer_text
from goalwire.records import record

BOOL = 'std_msgs/msg/Bool'
DIAGNOSTIC_STATUS = 'diagnostic_msgs/msg/DiagnosticStatus'
SILENT_AFTER = 5
"""How many looks a word that was repeated may be missing."""
REPEATS = 3
"""How often "not stopped" comes again before its publisher counts as one that repeats its word."""
_STOP_TYPES = {'std_srvs/srv/Trigger', 'std_srvs/srv/SetBool', 'std_srvs/srv/Empty'}
_STOP_NAMES = ('estop', 'e_stop', 'emergency_stop')
_RELEASE_NAMES = ('release', 'reset', 'clear', 'resume')
_STATE_ENDS = ('ped', '_state', '_active')
_ERROR = 2
_MOST_TEXT = 300
_MOST_LOST = 64


@record
class StopService:
    """A service that stops a robot."""

    name: str
    type_name: str

    @property
    def values(self) -> dict[str, bool]:
        """The fields of the request that stops."""
        return {'data': True} if self.can_release else {}

    @property
    def can_release(self) -> bool:
        """Whether the same service, called with false, releases the robot."""
        return self.type_name.endswith('SetBool')


def stop_services(services: Sequence[tuple[str, list[str]]]) -> list[StopService]:
    """Return the emergency stops among services: std_srvs types, named estop, e_stop or emergency_stop."""
    return [
        StopService(name, types[0])
        for name, types in services
        if types[0] in _STOP_TYPES
        and any(word in name.lower() for word in _STOP_NAMES)
        and not any(word in name.lower().rpartition('/')[2] for word in _RELEASE_NAMES)
    ]


def says_state(topic: str, type_name: str) -> bool:
    """Return whether a topic says how an emergency stop stands.

    A Bool does, named emergency_stopped, or as a stop with _state or _active; true means stopped. So does
    a DiagnosticStatus, named as a stop with _status.
    """
    last = topic.lower().rpartition('/')[2]
    ends = {BOOL: _STATE_ENDS, DIAGNOSTIC_STATUS: ('_status',)}.get(type_name, ())
    return any(last == name + end for name in _STOP_NAMES for end in ends)


class Standing(Enum):
    """The states of an emergency stop."""

    UNTOLD = 'untold'
    RELEASED = 'released'
    STOPPED = 'stopped'
    UNKNOWN = 'unknown'
    """It was reported, and is not reported any more."""


@record
class Word:
    """A publisher's statement about the emergency stop."""

    node: str
    topic: str
    stopped: bool
    reason: str = ''
    by: str = ''
    """The one that has stopped it, or an empty text."""
    is_switch: bool = False
    """Whether the node serves the emergency stop, too."""


def word_of(message: Any, node: str, topic: str, *, is_switch: bool) -> Word:
    """Return the report in a Bool or a DiagnosticStatus.

    A DiagnosticStatus may have the values `stopped` ('true' or 'false') and `by`; without the first its
    level says it, ERROR or worse. Its message is the reason.
    """
    if hasattr(message, 'data'):
        return Word(node, topic, bool(message.data), is_switch=is_switch)
    values = {each.key: each.value for each in message.values}
    level = message.level[0] if isinstance(message.level, bytes) else int(message.level)
    stopped = values['stopped'] == 'true' if 'stopped' in values else level >= _ERROR
    reason, by = (peer_text(text, _MOST_TEXT) for text in (message.message, values.get('by', '')))
    return Word(node, topic, stopped, reason if stopped else '', by if stopped else '', is_switch)


class _Voice:
    """One publisher: its last word, whether it repeats that, and how many looks ago it did."""

    def __init__(self, word: Word) -> None:
        self.word = word
        self.repeats = False
        self._same = 0
        self.missed = 0
        self.was_seen = False  # in the graph, which may show a publisher later than its first message

    def say(self, word: Word) -> None:
        # People press STOP again and again, and a node may say "stopped" at each press. Nobody releases a
        # robot again and again: a node that keeps saying "not stopped" does so by the clock.
        repeated = word == self.word and not word.stopped and self.missed <= SILENT_AFTER
        self._same = self._same + 1 if repeated else 0
        self.repeats = self.repeats or self._same >= REPEATS
        self.word, self.missed = word, 0

    @property
    def is_silent(self) -> bool:
        return self.repeats and self.missed > SILENT_AFTER


class EmergencyState:
    """One robot's emergency stop, as its publishers tell it. Its owner looks at equal times."""

    def __init__(self) -> None:
        self.servers: tuple[StopService, ...] = ()
        """The servers that are there."""
        self.known: tuple[StopService, ...] = ()
        """The present servers, or else the last ones."""
        self._voices: dict[tuple[str, bytes], _Voice] = {}
        self._lost: dict[str, Word] = {}

    # -- what comes ------------------------------------------------------------------------------------------

    def serve(self, servers: Sequence[StopService]) -> None:
        """Note the present servers."""
        self.servers = tuple(servers)
        self.known = self.servers or self.known

    def hear(self, publisher: bytes, word: Word) -> None:
        """Note a publisher's report; `publisher` tells the publishers of one topic apart."""
        key = (word.topic, publisher)
        if key in self._voices:
            self._voices[key].say(word)
        else:
            self._voices[key] = _Voice(word)
        if word.is_switch:
            self._lost.clear()
        self._lost.pop(word.node, None)

    def keep(self, publishers: Collection[tuple[str, bytes]]) -> None:
        """Forget the publishers that have gone: `publishers` are the present ones, with their topics."""
        for key, voice in list(self._voices.items()):
            if key in publishers:
                voice.was_seen = True
            elif voice.was_seen:
                del self._voices[key]
                if len(self._lost) < _MOST_LOST:
                    self._lost[voice.word.node] = voice.word

    def look(self) -> None:
        """Count for how many looks each publisher is silent.

        Looks and not seconds: a console that was held up has missed nothing.
        """
        for voice in self._voices.values():
            voice.missed += 1

    # -- what follows ----------------------------------------------------------------------------------------

    @property
    def standing(self) -> Standing:
        """The state of the emergency stop."""
        voices = self._voices.values()
        if any(voice.word.stopped for voice in voices):
            return Standing.STOPPED
        if self._lost or any(voice.is_silent for voice in voices):
            return Standing.UNKNOWN
        return Standing.RELEASED if voices else Standing.UNTOLD

    @property
    def reason(self) -> str:
        """Why it is stopped, or why that is not known; '' otherwise."""
        stopped = [voice.word for voice in self._voices.values() if voice.word.stopped]
        if stopped:
            told = [word.reason for word in stopped if word.reason]
            return told[0] if told else f'{stopped[0].node} says so on {stopped[0].topic}'
        silent = [voice.word for voice in self._voices.values() if voice.is_silent]
        if silent:
            return f'{silent[0].node} has fallen silent on {silent[0].topic}. {_last(silent[0])}'
        for word in self._lost.values():
            return f'{word.node}, which told it on {word.topic}, has gone. {_last(word)}'
        return ''

    @property
    def by(self) -> str:
        """The one that has stopped it; '' if nobody says so, or if the reason has it already."""
        for voice in self._voices.values():
            if voice.word.stopped and voice.word.by:
                return '' if voice.word.by in voice.word.reason else voice.word.by
        return ''

    @property
    def can_release(self) -> tuple[StopService, ...]:
        """The servers that release the stop."""
        return tuple(server for server in self.servers if server.can_release)


def _last(word: Word) -> str:
    return f'It last said: {"stopped" if word.stopped else "not stopped"}'
