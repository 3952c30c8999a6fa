"""The life of a context: everything that waits is woken when it ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.execution.monotonic import STEADY, SteadyClock
from goalwire.execution.waiting import Waiter, WireWaiter

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.transport.contract import Session, WirePoller


class ShutdownWatch:
    """Somebody who wants to know when a shutdown signal ends."""

    __slots__ = ('_shutdown_signal', '_wake')

    def __init__(self, shutdown_signal: ShutdownSignal, wake: Callable[[], None]) -> None:
        self._shutdown_signal = shutdown_signal
        self._wake = wake

    def close(self) -> None:
        """Watch no more."""
        self._shutdown_signal._watchers.pop(self, None)  # noqa: SLF001

    def notify(self) -> None:
        """Pass the end on."""
        self._wake()


class ShutdownSignal:
    """Ends once, for whatever reason. `clock` is the time that everything under this context lives in."""

    __slots__ = (
        '__weakref__',
        '_session',
        '_waiters',
        '_watchers',
        'alive',
        'clock',
        'external_sleepers',
        'idle_waiters',
        'reason',
        'wire_poller',
    )

    def __init__(self, clock: SteadyClock = STEADY) -> None:
        self.clock = clock
        self.alive = True
        self.reason: str | None = None
        self.wire_poller: WirePoller | None = None
        """Where threads under this may wait on the wire, once there is a session that lets them."""
        self.idle_waiters: list[Waiter] = []
        """As many as have blocked at the same time; see `borrow_waiter`."""
        self.external_sleepers: set[object] = set()
        """Who sleeps under this where the wire does not reach it: asyncio loops, watchers of descriptors."""
        self._watchers: dict[ShutdownWatch, None] = {}
        self._waiters: dict[ReferenceType[WireWaiter], None] = {}
        self._session: Session | None = None

    def take_session(self, session: Session) -> None:
        """Let threads under this wait on a session's wire, as far as it has a place for that.

        When this ends, nothing more is sent by that session.
        """
        wire_poller = session.wire_poller
        if wire_poller is not None:
            wire_poller.external_sleepers = self.external_sleepers
            self.wire_poller = wire_poller
        self._session = session  # then look: who ends this looks here after that
        if not self.alive:
            session.silence()

    def add_external_sleeper(self, who: object) -> None:
        """Have the session's own thread wait on the wire until `depend_no_more`. Any thread."""
        self.external_sleepers.add(who)
        if self.wire_poller is not None:
            self.wire_poller.ensure_polled()

    def remove_external_sleeper(self, who: object) -> None:
        """Undo `depend`; nothing where it was not called."""
        self.external_sleepers.discard(who)

    def new_waiter(self) -> Waiter:
        """A place for one thread to sleep in while it waits for what the wire may bring; the end wakes it."""
        return WireWaiter(self)

    def borrow_waiter(self) -> Waiter:
        """The same for a short while: it goes back to `idle_waiters`. To make one takes five calls.

        Who had it before may still wake it: look again at what you wait for, as after every wake-up.
        """
        try:
            return self.idle_waiters.pop()
        except IndexError:
            return WireWaiter(self)

    def wake_at_end(self, waiter: WireWaiter) -> None:
        """Wake `waiter`, held weakly, when this ends: for all its life, where a watch is for one sleep."""
        self._waiters[ref(waiter, self._forget)] = None

    def _forget(self, reference: ReferenceType[WireWaiter]) -> None:
        self._waiters.pop(reference, None)

    def end(self, reason: str) -> bool:
        """End it and tell everybody; False if it has ended before. Takes no lock: signal handlers call it."""
        if not self.alive:
            return False
        self.reason = reason
        self._silence()  # first: who sees that this has ended relies on it
        self.alive = False
        self._silence()  # of a session that was taken in between
        self._session = None
        self._tell()
        return True

    def watch(self, wake: Callable[[], None]) -> ShutdownWatch:
        """Call `wake` once when this ends; at once if it has ended.

        It may run on any thread and inside a signal handler: it must only wake somebody, and take no lock.
        """
        watch = ShutdownWatch(self, wake)
        self._watchers[watch] = None
        if not self.alive:
            self._tell()
        return watch

    def _silence(self) -> None:
        session = self._session
        if session is not None:
            session.silence()

    def _tell(self) -> None:
        while self._watchers:
            try:
                watch, _ = self._watchers.popitem()
            except KeyError:
                break
            watch.notify()
        # Python 3.11 may collect garbage while it makes a tuple of this, which then changes: so a list.
        for reference in list(self._waiters):
            waiter = reference()
            if waiter is not None:
                waiter.wake()


class ContextLike(Protocol):
    """What execution needs of a context."""

    @property
    def shutdown_signal(self) -> ShutdownSignal:
        """Its life."""

    def ok(self) -> bool:
        """Whether it is initialised and not shut down."""


_provider: list[Callable[[], ContextLike]] = []


def provide_default_context(provider: Callable[[], ContextLike]) -> None:
    """Say where `default_context` finds the default context; the front does, once."""
    _provider[:] = [provider]


def default_context() -> ContextLike:
    """The context for what was made without one. Raises RuntimeError where no front was imported."""
    if not _provider:
        raise RuntimeError('there is no default context: pass context=..., or import rclpy first')
    return _provider[0]()
