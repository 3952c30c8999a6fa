"""The emergency stop of one robot: its servers, and the robot's reports.

Only reports count, not the console's own requests: a robot is stopped if it reports so. The rules:

- The last report of each publisher counts. If one of them is "stopped", the robot is stopped.
- If a publisher that repeated its report becomes silent, or a publisher is gone, the state is unknown.
  It stays unknown until the same node reports again, or a node that serves the emergency stop.
- The state of a robot without any report is "untold": it may have a service but no topic for its state.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from enum import Enum

from goalwire.observe.emergency_stops import StopService, Word

SILENT_AFTER = 5
"""How many calls of `look` may pass without a report before a publisher that repeats reports is silent."""
REPEATS = 3
"""The number of equal "not stopped" reports after which a publisher is expected to repeat them."""
_MOST_LOST = 64


class Standing(Enum):
    """The states of an emergency stop."""

    UNTOLD = 'untold'
    RELEASED = 'released'
    STOPPED = 'stopped'
    UNKNOWN = 'unknown'
    """The state was reported, but is not reported any more."""


class _Voice:
    """One publisher: its last report, whether it repeats reports, and the calls of `look` since then."""

    def __init__(self, word: Word) -> None:
        self.word = word
        self.repeats = False
        self._same = 0
        self.missed = 0
        self.was_seen = False  # True once the graph has shown the publisher

    def say(self, word: Word) -> None:
        # A node may report "stopped" at each press of STOP, and people press it repeatedly. Nobody releases a
        # robot repeatedly: so a node that repeats "not stopped" reports periodically.
        repeated = word == self.word and not word.stopped and self.missed <= SILENT_AFTER
        self._same = self._same + 1 if repeated else 0
        self.repeats = self.repeats or self._same >= REPEATS
        self.word, self.missed = word, 0

    @property
    def is_silent(self) -> bool:
        return self.repeats and self.missed > SILENT_AFTER


class EmergencyState:
    """One robot's emergency stop, as its publishers report it. Its owner calls `look` periodically."""

    def __init__(self) -> None:
        self.servers: tuple[StopService, ...] = ()
        """The present servers of the emergency stop."""
        self.known: tuple[StopService, ...] = ()
        """The present servers of the emergency stop; if there are none, the latest that were present."""
        self._voices: dict[tuple[str, bytes], _Voice] = {}
        self._lost: dict[str, Word] = {}

    # -- servers and their reports ---------------------------------------------------------------------------

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
        """Count for how many calls of this method each publisher has been silent.

        Calls are counted, not seconds, so that a delay of the console does not count as silence.
        """
        for voice in self._voices.values():
            voice.missed += 1

    # -- the state that follows from reports -----------------------------------------------------------------

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
        """The reason why the robot is stopped, or why its state is unknown; '' otherwise."""
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
        """The name of the client that has stopped the robot; '' if unknown or named in the reason."""
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
