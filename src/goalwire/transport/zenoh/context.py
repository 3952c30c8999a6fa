"""What every endpoint of one session shares."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from threading import Event
from typing import Never, Protocol

from goalwire.errors import TransportError
from goalwire.transport.contract import GraphEntity
from goalwire.transport.endpoint import ForkGuard
from goalwire.transport.reports import RejectCounters
from goalwire.transport.zenoh.turn import Turns
from goalwire.transport.zenoh.wire import Wire


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
        self.enter: Callable[[object], None] = self._held.add
        """A callback of this owner was handed to zenoh."""

    def leave(self, owner: object) -> None:
        """Zenoh has let go of it; runs on any thread."""
        self._held.discard(owner)
        if self._nobody_left is not None and not self._held:
            self._nobody_left.set()

    def wait(self, timeout: float) -> bool:
        """Wait until zenoh holds none; False if it still does after `timeout` seconds."""
        self._nobody_left = Event()
        return not self._held or self._nobody_left.wait(timeout)


class ZenohContext:
    """One open Zenoh session and its counters."""

    def __init__(self, wire: Wire, domain_id: int) -> None:
        self.wire = wire
        self.errors = wire.errors
        """What the wire raises where it refuses."""
        self.domain_id = domain_id
        self.id = wire.id
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        self.turns = Turns()
        self.next_id = count().__next__
        self.own: dict[str, GraphEntity] = {}
        """What this session's own tokens say, so that they need not be read."""

    @contextmanager
    def refusing(self, title: str) -> Iterator[None]:
        """Raise TransportError where the wire refuses what the block declares."""
        try:
            yield
        except self.errors as error:
            reason = self.wire.explain(error)
            raise TransportError(f'{title}: zenoh refused the declaration: {reason}') from None
