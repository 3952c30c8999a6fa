"""What every endpoint of one session shares, and what every declared thing has in common."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from itertools import count
from threading import Event, RLock
from typing import Never, Protocol

import zenoh

from goalwire.errors import ClosedError
from goalwire.transport.fork import ForkGuard
from goalwire.transport.zenoh.rejects import Rejects


class Declared(Protocol):
    """What zenoh declared for us."""

    def undeclare(self) -> object:
        """Take it off the wire."""


def undeclare(declared: Declared) -> None:
    """Take something off the wire, or leave that to the thread that is using it.

    Zenoh's Python objects refuse while another thread is inside one of their methods, and undeclare
    themselves when the last reference goes: so the caller drops its own afterwards.
    """
    with suppress(RuntimeError):  # "Already borrowed"
        declared.undeclare()


def taken_back(*_: object, **__: object) -> Never:
    """Stand in for a method of something undeclared; its owner turns this into ClosedError."""
    raise RuntimeError('undeclared')


class InFlight:
    """The callbacks zenoh still holds: while one is held it may be running or be about to."""

    def __init__(self) -> None:
        self._held: set[object] = set()
        self._nobody_left: Event | None = None

    def enter(self, owner: object) -> None:
        """A callback of `owner` was handed to zenoh."""
        self._held.add(owner)

    def leave(self, owner: object) -> None:
        """Zenoh has let go of it; runs on any thread."""
        self._held.discard(owner)
        if self._nobody_left is not None and not self._held:
            self._nobody_left.set()

    def wait(self, timeout: float) -> bool:
        """Wait until zenoh holds none; False if it still does after `timeout` seconds."""
        self._nobody_left = Event()
        return not self._held or self._nobody_left.wait(timeout)


class Core:
    """One open zenoh session and its counters."""

    def __init__(self, session: zenoh.Session, domain_id: int) -> None:
        self.zenoh = session
        self.domain_id = domain_id
        self.id = str(session.zid())
        self.guard = ForkGuard()
        self.rejects = Rejects()
        self.in_flight = InFlight()
        self.next_id = count().__next__


OTHER_CLOSER_S = 15.0
"""How long to wait for another thread that closes the same; zenoh gives up on a mute peer after 10 s."""


class Place:
    """A declared thing's place on the wire: whether it is still held, and how it is given up."""

    __slots__ = ('_guard', '_leave', '_turn', 'closed', 'title')

    def __init__(self, title: str, guard: ForkGuard, leave: Callable[[], None]) -> None:
        self.title = title
        self.closed = False
        self._guard = guard
        self._leave = leave
        self._turn = RLock()

    @property
    def is_forked(self) -> bool:
        """True in a child forked since."""
        return self._guard.is_forked

    def check(self) -> None:
        """Raise ClosedError or ForkedError where the place is no longer held."""
        self._guard.check(self.title)
        if self.closed:
            raise ClosedError(
                f'{self.title} was used after it, its node or its context had been closed; '
                f'declare it again, or stop using it first'
            )

    def give_up(self) -> None:
        """Undeclare, once; a forked child has nothing to undeclare.

        Whoever comes second waits for the first, so that it may rely on the end as well; a call from within
        the closing itself returns at once.
        """
        if self._guard.is_forked or not self._turn.acquire(timeout=OTHER_CLOSER_S):
            return
        try:
            if not self.closed:
                self.closed = True
                self._leave()
        finally:
            self._turn.release()
