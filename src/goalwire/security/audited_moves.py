"""Entries of the audit log about acts that move a robot: one for each goal, few for a stream of commands.

Commands on a topic come tens of times a second. So a stream has an entry when it begins, one each minute
while it goes on, and one when it has ended, each with the number of messages since the one before.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from threading import Lock
from time import monotonic
from typing import TypeAlias

MOVES = 'moves'
"""The outcome, in an entry of the audit log, of an allowed act that moves a robot."""
SILENT_S = 10.0
"""A stream ends after so many seconds without a message."""
EACH_S = 60.0
"""While a stream of moving commands goes on, it has an entry in the audit log every so many seconds."""
MOST_STREAMS = 1024
"""How many streams are told apart: a peer could invent names. Each message of a further stream has an entry.
"""

Entry: TypeAlias = dict[str, str]


def write_entry(outcome: str, who: str, act: str, name: str, reason: str, **more: str) -> Entry:
    """Return an entry of the audit log about something that happens now."""
    time = datetime.now(UTC).isoformat(timespec='milliseconds')
    return {'time': time, 'outcome': outcome, 'who': who, 'act': act, 'key': name, 'reason': reason, **more}


class _Stream:
    """Commands of one identity on one topic: when the latest came, and how many since the latest entry."""

    def __init__(self, now: float) -> None:
        self.written = self.latest = now
        self.count = 0


class Streams:
    """The streams of commands under way. Any thread may use it."""

    def __init__(self, write: Callable[[Entry], object], clock: Callable[[], float] = monotonic) -> None:
        """`write` gets the entries; it must not wait."""
        self._write = write
        self._clock = clock
        self._streams: dict[tuple[str, str, str], _Stream] = {}
        self._lock = Lock()

    def note(self, outcome: str, who: str, act: str, name: str, reason: str) -> None:
        """Note one message of an identity on a topic; the parameters are those of `write_entry`."""
        now, key = self._clock(), (who, act, name)
        with self._lock:
            stream = self._streams.get(key)
            if stream is not None and now - stream.latest < SILENT_S:
                stream.count += 1
                stream.latest = now
                if now - stream.written < EACH_S:
                    return
                count, stream.count, stream.written = stream.count, 0, now
                more = {'messages': str(count)}
            else:
                self._end(key)
                if len(self._streams) < MOST_STREAMS:
                    self._streams[key] = _Stream(now)
                more = {}
            self._write(write_entry(outcome, who, act, name, reason, **more))

    def look(self) -> None:
        """Write entries about the streams that have ended. To be called now and then."""
        now = self._clock()
        with self._lock:
            for key in [key for key, each in self._streams.items() if now - each.latest >= SILENT_S]:
                self._end(key)

    def close(self) -> None:
        """Write entries about all streams: the program ends."""
        with self._lock:
            for key in list(self._streams):
                self._end(key)

    def _end(self, key: tuple[str, str, str]) -> None:
        stream = self._streams.pop(key, None)
        if stream is not None:
            who, act, name = key
            self._write(
                write_entry('ended', who, act, name, 'no more messages come', messages=str(stream.count))
            )
