"""Puts one publisher's messages in order, each once, its history before its live messages.

Pure: its owner tells it what came, live or as the answer to a query, and asks it which query to send next.
While a query is out, live messages wait; otherwise the first of them would make all history look outdated.
Zenoh 1.10.2's own advanced subscriber does not wait after its first query, and so loses history.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar('T')

_MASK = 0xFFFF_FFFF
_HALF = 0x8000_0000


def is_newer(number: int, other: int | None) -> bool:
    """Whether `number` comes after `other` (None: before all); numbers of 32 bits, which wrap around."""
    return other is None or 0 < ((number - other) & _MASK) < _HALF


class StreamState(Generic[T]):
    """The publishers of one address: one that numbers its messages, or all of a session that do not.

    `emit` gets each message that is due. Where `recovers`, what is missing is asked for again.
    Every publisher is known by its gid; `number` is the wire's where it numbers, else the sender's own.
    """

    __slots__ = (
        '_answered',
        '_emit',
        '_held',
        '_history',
        '_numbered',
        '_recovers',
        '_seen',
        'is_alive',
        'is_asking',
    )

    def __init__(self, emit: Callable[[T], None], depth: int, *, numbered: bool, recovers: bool) -> None:
        self.is_asking = False
        self.is_alive = False
        """True while a token shows the publisher."""
        self._emit = emit
        self._history = f'_max={depth}'
        self._numbered = numbered
        self._recovers = recovers and numbered
        self._held: list[tuple[int, bytes, T]] = []
        self._seen: dict[bytes, int] = {}
        self._answered: dict[bytes, int] = {}

    @property
    def gids(self) -> list[bytes]:
        """The gids of the publishers of which messages came."""
        return list(self._seen)

    def ask(self) -> str | None:
        """Return the question for the history, or None where one is out already; `end` must follow."""
        return self._question(self._history)

    def live(self, gid: bytes, number: int, item: T, *, is_first: bool) -> str | None:
        """Take a message as it was published; return a question to ask before it is due, or None.

        `is_first` where the publisher has sent nothing before it.
        """
        if self.is_asking:
            self._held.append((number, gid, item))
            return None
        last = self._seen.get(gid)
        if last is None and not is_first:  # never heard, yet not its first: there may be history
            self._held.append((number, gid, item))
            return self.ask()
        if self._recovers and last is not None and is_newer(number, last + 1):
            self._held.append((number, gid, item))
            return self._question(f'_sn={(last + 1) & _MASK}..')
        self._take(gid, number, item)
        return None

    def heartbeat(self, number: int) -> str | None:
        """Take a numbering publisher's word that `number` is its last; return a question or None."""
        last = next(iter(self._seen.values()), None)
        if last is None:
            return self.ask()
        if is_newer(number, last):
            return self._question(f'_sn={(last + 1) & _MASK}..{number}')
        return None

    def answer(self, gid: bytes, number: int, item: T) -> None:
        """Take a message that came as an answer.

        A publisher that keeps few messages may have dropped for this one what came live and waits here.
        """
        if is_newer(number, self._seen.get(gid)):
            if self._held:
                self._take_held_before(gid, number)
            self._seen[gid] = self._answered[gid] = number
            self._emit(item)

    def _take_held_before(self, gid: bytes, number: int) -> None:
        """Emit the live messages of a publisher that came before its answer `number`."""
        before: list[tuple[int, bytes, T]] = []
        rest: list[tuple[int, bytes, T]] = []
        for each in self._held:
            (before if each[1] == gid and is_newer(number, each[0]) else rest).append(each)
        self._held = rest
        for held, _, item in sorted(before, key=lambda each: (each[0] - number) & _MASK):
            self._take(gid, held, item)

    def end(self) -> None:
        """All answers to the question have come: what waited is due, whatever is still missing."""
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
        return text

    def _take(self, gid: bytes, number: int, item: T) -> None:
        """Emit a live message unless it came before.

        Without the wire's numbers the sender's own decide; several of its threads may overtake each other,
        so only an answer makes the messages up to it outdated.
        """
        seen = self._seen.get(gid)
        if is_newer(number, seen if self._numbered else self._answered.get(gid)):
            if is_newer(number, seen):
                self._seen[gid] = number
            self._emit(item)
