"""Puts one publisher's messages in order, each once, its history before its live messages.

Pure: the owner passes in each message, whether live or as the answer to a query, and gets the next query to
send. While a query is open, live messages wait; otherwise the first of them would make all history outdated.
Zenoh 1.10.2's own advanced subscriber does not wait after its first query, and so loses history.

Anybody on the network can send a message in a publisher's name with a number far ahead. If such a number made
all lower ones outdated, one message would silence the publisher for good. So a number behind a gap counts
only after the publisher's own answer has filled the gap or has gone beyond it. Until then the message and
those that follow it are delivered, too, but counted apart: they are a *run* beside the publisher's line of
numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar('T')

_MASK = 0xFFFF_FFFF
_HALF = 0x8000_0000

MOST_RUNS = 8
"""How many runs of one publisher are remembered; a message of an older run may be delivered twice."""


def is_newer(number: int, other: int | None) -> bool:
    """Return whether `number` comes after `other`; True if `other` is None. 32-bit numbers wrap around."""
    return other is None or 0 < ((number - other) & _MASK) < _HALF


class StreamState(Generic[T]):
    """The messages of one publisher that numbers them, or of all publishers in a session that do not.

    `emit` gets each message that is due. With `recovers`, missing messages are requested again. A publisher
    is identified by its gid. `number` is the wire's number of the message, or the attachment's if there is
    none.
    """

    __slots__ = (
        '_answered',
        '_emit',
        '_held',
        '_history',
        '_numbered',
        '_recovers',
        '_runs',
        '_seen',
        'asked_s',
        'is_alive',
        'is_asking',
    )

    def __init__(self, emit: Callable[[T], None], depth: int, *, numbered: bool, recovers: bool) -> None:
        self.is_asking = False
        self.asked_s = 0.0
        """The time at which the last query was sent; set by the sender."""
        self.is_alive = False
        """True while a token shows the publisher."""
        self._emit = emit
        self._history = f'_max={depth}'
        self._numbered = numbered
        self._recovers = recovers and numbered
        self._held: list[tuple[int, bytes, T]] = []
        self._seen: dict[bytes, int] = {}
        self._answered: dict[bytes, int] = {}
        self._runs: dict[bytes, list[tuple[int, int]]] = {}
        """The runs behind gaps that no answer has filled, by gid: the first and last number of each run."""

    def ask(self) -> str | None:
        """Return the query for the history; None if another query is open. `end` must follow."""
        return self._question(self._history)

    def live(self, gid: bytes, number: int, item: T, *, is_first: bool) -> str | None:
        """Take a live message; return a query to send before the message is due, or None.

        `is_first` says that it is the publisher's first message.
        """
        if self.is_asking:
            self._held.append((number, gid, item))
            return None
        if self._runs and self._joins_run(gid, number, item):
            return None
        last = self._seen.get(gid)
        if last is None and not is_first:  # a new publisher, but not its first message: there may be history
            self._held.append((number, gid, item))
            return self.ask()
        if self._recovers and last is not None and is_newer(number, last + 1):
            self._held.append((number, gid, item))
            return self._question(f'_sn={(last + 1) & _MASK}..')
        self._take(gid, number, item)
        return None

    def heartbeat(self, number: int) -> str | None:
        """Take a heartbeat, which says that `number` is the last one; return a query or None."""
        last = next(iter(self._seen.values()), None)
        if last is None:
            return self.ask()
        if is_newer(number, last):
            return self._question(f'_sn={(last + 1) & _MASK}..{number}')
        return None

    def answer(self, gid: bytes, number: int, item: T) -> None:
        """Take a message that came as an answer.

        Messages with lower numbers may wait here that the publisher does not keep any more: they come first.
        """
        if is_newer(number, self._seen.get(gid)):
            if self._held:
                self._take_held_before(gid, number)
            was_delivered = self._is_in_run(gid, number)
            self._advance(gid, number)
            self._answered[gid] = number
            if not was_delivered:
                self._emit(item)

    def _take_held_before(self, gid: bytes, number: int) -> None:
        """Emit the held live messages that come before `number`, a message of the publisher's history."""
        before: list[tuple[int, bytes, T]] = []
        rest: list[tuple[int, bytes, T]] = []
        for each in self._held:
            (before if each[1] == gid and is_newer(number, each[0]) else rest).append(each)
        self._held = rest
        for held, _, item in sorted(before, key=lambda each: (each[0] - number) & _MASK):
            self._take(gid, held, item)

    def end(self) -> None:
        """Note that all answers to the query have come: the waiting messages are due now."""
        self.is_asking = False
        held, self._held = self._held, []
        if held:
            start = held[0][0] - _HALF
            for number, gid, item in sorted(held, key=lambda each: (each[0] - start) & _MASK):
                self._take(gid, number, item)

    def _question(self, text: str) -> str | None:
        if self.is_asking:
            return None
        self.is_asking = True
        self.asked_s = float('inf')
        return text

    def _take(self, gid: bytes, number: int, item: T) -> None:
        """Emit a live message unless it came before.

        Without the wire's numbers those of the attachment decide. Several threads of the sender may overtake
        each other, so only an answer makes the messages up to it outdated.
        """
        seen = self._seen.get(gid)
        if self._numbered:
            if self._is_next(number, seen):
                self._advance(gid, number)
                self._emit(item)
            elif is_newer(number, seen) and not self._joins_run(gid, number, item):
                runs = self._runs.setdefault(gid, [])
                runs.append((number, number))
                del runs[:-MOST_RUNS]
                self._emit(item)
        elif is_newer(number, self._answered.get(gid)):
            if is_newer(number, seen):
                self._seen[gid] = number
            self._emit(item)

    @staticmethod
    def _is_next(number: int, seen: int | None) -> bool:
        """Return whether no message is missing before this message."""
        return number == (0 if seen is None else (seen + 1) & _MASK)

    def _advance(self, gid: bytes, number: int) -> None:
        """Mark all of a publisher's messages up to `number` as outdated, and its runs up to that number."""
        self._seen[gid] = number
        runs = self._runs.get(gid)
        if runs:
            left = [each for each in runs if is_newer(each[1], number)]
            self._seen[gid] = next((last for first, last in left if not is_newer(first, number + 1)), number)
            self._runs[gid] = left = [each for each in left if is_newer(each[1], self._seen[gid])]
            if not left:
                del self._runs[gid]

    def _joins_run(self, gid: bytes, number: int, item: T) -> bool:
        """Return whether a message belongs to a run; deliver it if it is the run's next one."""
        runs = self._runs.get(gid, ())
        for at, (first, last) in enumerate(runs):
            if number == (last + 1) & _MASK:
                self._runs[gid][at] = first, number
                self._emit(item)
                return True
        return self._is_in_run(gid, number)

    def _is_in_run(self, gid: bytes, number: int) -> bool:
        """Return whether a message was delivered in a run."""
        return any(
            (number - first) & _MASK <= (last - first) & _MASK for first, last in self._runs.get(gid, ())
        )
