"""The things that all endpoints of a session share: wire, counters, the order of publications on a key.

Zenoh drops a message that has found no room for 50 ms, and tells nobody (1.10.2). The time does not depend on
the size, so a message of 100 MB never gets through. So large ones of reliable publishers go at once on each
link that has room. On every other link they are sent with congestion control BLOCK, on a thread of that link.
As many may wait for a link as the publisher keeps; what is dropped beyond that is counted. A peer that stops
reading takes nothing away from others that way. eclipse-zenoh's session shows no links, and counts as one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from threading import Condition, RLock, Thread
from time import monotonic
from typing import NamedTuple
from weakref import WeakValueDictionary

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.concurrency.forks import ForkGuard
from goalwire.errors import TransportError
from goalwire.reports import RejectCounters, report_failure
from goalwire.transport.contract import GraphEntity
from goalwire.transport.zenoh.wire import Wire

LARGE = 1 << 18
"""Bytes from which a message counts as large: a link's queue holds four of these (settings/built_in.py).

The thread costs a message 0.1 ms. Of 200 messages of 500 KB in a row a third were lost without it; of 200 KB
none.
"""


class Waiting(NamedTuple):
    """A message that waits for room on one link."""

    owner: object
    size: int
    send: Callable[[], None]
    """Hands the message to the wire, and waits for room; may fail if the publisher has gone."""


class Lane:
    """The messages of one key that wait for one link."""

    __slots__ = ('sending', 'waiting')

    def __init__(self) -> None:
        self.waiting: deque[Waiting] = deque()
        self.sending: Waiting | None = None

    def has(self, owner: object) -> bool:
        """Whether a message of an owner waits, or is being sent."""
        sending = self.sending
        return (sending is not None and sending.owner is owner) or any(
            each.owner is owner for each in self.waiting
        )


class Turn:
    """The order of publications on one key.

    A message is numbered, stamped and sent in one critical section: what a signal's handler publishes while
    its thread is just publishing on the key follows that.
    """

    def __init__(self) -> None:
        self.section = CriticalSection()
        self.is_busy = False
        """True while messages wait; others may not overtake them on the same link then."""
        self.lanes: dict[object, Lane] = {}
        """The links for which messages wait. Only who has the section may look."""
        self._changed = Condition(self.section.lock)

    def post(self, link: object, message: Waiting, depth: int) -> Waiting | None:
        """Queue a message behind those that wait for a link; return the owner's oldest, which is dropped, if
        `depth` of these wait already.
        """
        with self.section.lock:
            lane = self.lanes.get(link)
            if lane is None:
                lane = Lane()  # its thread waits for the lock; if it cannot start, nothing has changed
                Thread(
                    target=self._send_all, args=(link, lane), name='zenoh large messages', daemon=True
                ).start()
                self.lanes[link] = lane
                self.is_busy = True
            fellows = [each for each in lane.waiting if each.owner is message.owner]
            dropped = fellows[0] if len(fellows) >= depth else None
            if dropped is not None:
                lane.waiting.remove(dropped)
            lane.waiting.append(message)
        return dropped

    def wait(self) -> None:
        """Wait until no message waits; others may have the section meanwhile."""
        section = self.section
        with section.lock:
            was_busy = section.is_busy
            try:
                section.is_busy = False
                self._changed.wait_for(lambda: not self.is_busy)
            finally:
                section.is_busy = was_busy

    def finish(self, owner: object, timeout: float) -> list[int]:
        """Wait until an owner's messages have gone; return the sizes of those cancelled at the end."""
        if not self.is_busy:
            return []
        end = monotonic() + timeout
        with self.section.lock:
            self._changed.wait_for(lambda: not self._has(owner), max(end - monotonic(), 0))
            sizes: list[int] = []
            for lane in self.lanes.values():
                sizes += [each.size for each in lane.waiting if each.owner is owner]
                lane.waiting = deque(each for each in lane.waiting if each.owner is not owner)
            return sizes

    def _has(self, owner: object) -> bool:
        return any(lane.has(owner) for lane in self.lanes.values())

    def _send_all(self, link: object, lane: Lane) -> None:
        while True:
            with self.section.lock:
                lane.sending = lane.waiting.popleft() if lane.waiting else None
                if lane.sending is None:
                    del self.lanes[link]
                    self.is_busy = bool(self.lanes)
                self._changed.notify_all()
                if lane.sending is None:
                    return
                send = lane.sending.send
            try:
                send()
            except Exception as error:  # out of memory, for example: the waiting messages go out all the same
                report_failure('large message', error)


class Turns:
    """The turns of a session, by key; each goes with the last publisher that holds it."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._of: WeakValueDictionary[str, Turn] = WeakValueDictionary()

    def of(self, key: str) -> Turn:
        """Return the turn that all publishers of a key share."""
        with self._lock:
            turn = self._of.get(key)
            if turn is None:
                turn = self._of[key] = Turn()
            return turn


class ZenohContext:
    """One open Zenoh session and its counters."""

    def __init__(self, wire: Wire, domain_id: int) -> None:
        self.wire = wire
        self.errors = wire.errors
        """The exceptions that the wire raises."""
        self.domain_id = domain_id
        self.id = wire.id
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        self.turns = Turns()
        self.next_id = count().__next__
        self.own: dict[str, GraphEntity] = {}
        """The meaning of this session's own tokens, so that they need not be parsed."""

    @contextmanager
    def refusing(self, title: str) -> Iterator[None]:
        """Raise TransportError if the wire refuses a declaration of the block."""
        try:
            yield
        except self.errors as error:
            reason = self.wire.explain(error)
            raise TransportError(f'{title}: zenoh refused the declaration: {reason}') from None
