"""The things that all endpoints of a session share: wire, counters, the order of publications on a key.

Zenoh drops a message that has found no room for 50 ms, without an error (1.10.2). The time does not depend on
the size, so a message of 100 MB never arrives. So a reliable publisher sends a large message at once on each
link that has room. On every other link a thread of that link sends it with congestion control BLOCK. As many
messages may wait for a link as the publisher's history depth; further ones are dropped and counted. So a peer
that stops reading does not disturb the others. eclipse-zenoh's session shows no links, and counts as one
link.
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
from goalwire.fault_reports import RejectCounters, report_failure
from goalwire.transport.contract import GraphEntity
from goalwire.transport.zenoh.wire import Wire

LARGE = 1 << 18
"""Messages of this many bytes or more count as large. A link's queue holds four (settings/built_in.py).

Sending on a thread costs each message 0.1 ms. Without the thread a third of 200 messages of 500 KB in a row
were lost, but none of 200 messages of 200 KB.
"""


class Waiting(NamedTuple):
    """A message that waits for room on one link."""

    owner: object
    size: int
    send: Callable[[], None]
    """Sends the message and waits for room; fails if the publisher has been undeclared."""


class Lane:
    """The messages of one key that wait for one link."""

    __slots__ = ('sending', 'waiting')

    def __init__(self) -> None:
        self.waiting: deque[Waiting] = deque()
        self.sending: Waiting | None = None

    def has(self, owner: object) -> bool:
        """Return whether a message of this owner, a publisher, waits or is being sent."""
        sending = self.sending
        return (sending is not None and sending.owner is owner) or any(
            each.owner is owner for each in self.waiting
        )


class Turn:
    """The order of publications on one key.

    A message is numbered, stamped and sent in one critical section. If a signal handler publishes on the key
    while its thread is in the section, the handler's message follows.
    """

    def __init__(self) -> None:
        self.section = CriticalSection()
        self.is_busy = False
        """True while messages wait. Later messages must not overtake them on the same link."""
        self.lanes: dict[object, Lane] = {}
        """The waiting messages by link. Only the thread in the section may read this."""
        self._changed = Condition(self.section.lock)

    def post(self, link: object, message: Waiting, depth: int) -> Waiting | None:
        """Queue a message for a link. If `depth` messages of its owner wait, drop and return their oldest."""
        with self.section.lock:
            lane = self.lanes.get(link)
            if lane is None:
                # The tables change only after the thread has started, since starting it may fail.
                lane = Lane()
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
        """Leave the section until no message waits, and enter it again."""
        section = self.section
        with section.lock:
            was_busy = section.is_busy
            try:
                section.is_busy = False
                self._changed.wait_for(lambda: not self.is_busy)
            finally:
                section.is_busy = was_busy

    def finish(self, owner: object, timeout: float) -> list[int]:
        """Wait until an owner's messages are sent; drop the rest after `timeout`, and return their sizes."""
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
            except Exception as error:  # out of memory, for example: later messages are sent nevertheless
                report_failure('large message', error)


class Turns:
    """The turns of a session, by key. A turn is deleted with the last publisher that uses it."""

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
        """The entities of this session's own tokens, so that these need not be parsed."""

    @contextmanager
    def refusing(self, title: str) -> Iterator[None]:
        """Raise TransportError if the wire refuses a declaration inside the block."""
        try:
            yield
        except self.errors as error:
            reason = self.wire.explain(error)
            raise TransportError(f'{title}: zenoh refused the declaration: {reason}') from None
