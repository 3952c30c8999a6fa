"""The shutdown signal: the end of a context, which wakes every thread and task that sleeps under it.

It also has what all waits of a context share: the clock, the wire, the waiters that are free.
"""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.errors import ShutDownBySignalError, ShutDownError
from goalwire.execution.time.steady_clock import STEADY, SteadyClock
from goalwire.execution.waiters import Waiter, WireWaiter, wake_all
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.transport.contract import Session


class ShutdownWatch:
    """A registered listener of a shutdown signal."""

    __slots__ = ('_watchers', 'wake')

    def __init__(self, watchers: dict[ShutdownWatch, None], wake: Callable[[], None]) -> None:
        self._watchers = watchers
        self.wake = wake
        """The function that is called at the shutdown."""
        watchers[self] = None

    def close(self) -> None:
        """Stop watching."""
        self._watchers.pop(self, None)


class Alarms(Protocol):
    """A thread that calls timer entries when they are due: `TimerThread`."""

    def set(self, entry: Any, due: int) -> None:
        """Have `entry` called at `due`, in ns of the steady clock."""

    def discard(self, entry: Any) -> None:
        """Remove `entry`, so that it is not called."""


class SpinListener(Protocol):
    """An object that is notified of threads that begin to spin without end."""

    def on_spin(self) -> None:
        """Note that the calling thread begins to spin without end."""


class ShutdownSignal:
    """The end of a context, which comes once. `clock` is the time of everything that belongs
    to the context.
    """

    __slots__ = (
        '__weakref__',
        '_session',
        '_waiters',
        '_watchers',
        'alarms',
        'alive',
        'clock',
        'early_looks',
        'external_sleepers',
        'idle_waiters',
        'reason',
        'spin_listeners',
        'wire_poller',
    )

    def __init__(self, clock: SteadyClock = STEADY) -> None:
        self.clock = clock
        self.alive = True
        self.alarms: Alarms | None = None
        """The thread that calls SpinWatch at its due times, if the context has such a thread."""
        self.early_looks: list[Callable[[], object]] = []
        """Functions that are called once, seconds after a spin without end has begun. The program has most
        likely made its nodes by then."""
        self.spin_listeners: WeakMembers[SpinListener] = WeakMembers()
        """Each thread that begins to spin without end calls their `on_spin`."""
        self.reason: str | None = None
        self.wire_poller: WirePoller | None = None
        """The wire on which threads of this context may wait; None before a session allows that."""
        self.idle_waiters: list[Waiter] = []
        """The waiters that `borrow_waiter` may give out again."""
        self.external_sleepers: set[object] = set()
        """Sleepers that do not wait on the wire themselves: asyncio loops, watchers of descriptors."""
        self._watchers: dict[ShutdownWatch, None] = {}
        self._waiters: WeakMembers[WireWaiter] = WeakMembers()
        self._session: Session | None = None

    def take_session(self, session: Session) -> None:
        """Let threads of this context wait on the wire of a session, if the session allows that.

        At the end of the context the session stops sending. Warns if Python runs without a GIL.
        """
        _warn_without_gil()
        wire_poller = session.wire_poller
        if wire_poller is not None:
            wire_poller.external_sleepers = self.external_sleepers
            self.wire_poller = wire_poller
        self._session = session  # before `alive` is read: `end` clears `alive`, then reads `_session`
        if not self.alive:
            session.silence()

    def add_external_sleeper(self, who: object) -> None:
        """Have the session's own thread wait on the wire until `remove_external_sleeper`. Callable from any
        thread.
        """
        self.external_sleepers.add(who)
        if self.wire_poller is not None:
            self.wire_poller.ensure_polled()

    def remove_external_sleeper(self, who: object) -> None:
        """Undo `add_external_sleeper`. Does nothing if that was not called."""
        self.external_sleepers.discard(who)

    def new_waiter(self) -> Waiter:
        """Return a waiter whose thread may wait on the wire. The end of the context wakes it."""
        return WireWaiter(self)

    def borrow_waiter(self) -> Waiter:
        """Return a waiter for one wait, after which the caller appends it to `idle_waiters`.

        That saves the five calls of a new waiter. A waker of an earlier owner may still wake it, so the
        caller looks at its condition again, as after every wake-up.
        """
        try:
            return self.idle_waiters.pop()
        except IndexError:
            return WireWaiter(self)

    def wake_at_end(self, waiter: WireWaiter) -> None:
        """Have `waiter` woken at the end, as long as it lives. It is held weakly. (`watch` is
        for one sleep.)
        """
        self._waiters.add(waiter)

    def end(self, reason: str) -> bool:
        """End the context and wake all sleepers; False if it has ended before.

        Takes no lock, since signal handlers call it.
        """
        if not self.alive:
            return False
        self.reason = reason
        self._silence()  # before `alive` changes: code that reads False relies on it
        self.alive = False
        self._silence()  # silence a session that was opened meanwhile
        self._session = None
        self._tell()
        return True

    @property
    def is_by_signal(self) -> bool:
        """True once a signal has ended the context, and not the program itself."""
        return self.reason in signal.Signals.__members__

    def end_error(self, what: str) -> ShutDownError:
        """Make the error of `what`, which came after the end.

        After a signal it is an ExternalShutdownException, too: the program was asked to end.
        """
        return (ShutDownBySignalError if self.is_by_signal else ShutDownError)(what)

    def end_in_child(self, reason: str) -> None:
        """End in a forked child, without waking sleepers: they are threads of the parent."""
        self.reason = reason
        self.alive = False
        self._session = None

    def watch(self, wake: Callable[[], None]) -> ShutdownWatch:
        """Have `wake` called once at the end; at once if the end has come already.

        `wake` may run on any thread and inside a signal handler. So it must only wake a sleeper, and take no
        lock.
        """
        watch = ShutdownWatch(self._watchers, wake)
        if not self.alive:
            self._tell()
        return watch

    def _silence(self) -> None:
        session = self._session
        if session is not None:
            session.silence()

    def _tell(self) -> None:
        # Signal handlers and several threads may call this at once: `popitem` gives each watch to one of
        # them.
        while self._watchers:
            try:
                watch, _ = self._watchers.popitem()
            except KeyError:
                break
            watch.wake()
        wake_all(self._waiters.alive())


def _warn_without_gil() -> None:
    """Warn if Python runs without a GIL. A session must be open, since its imports may turn the GIL on."""
    is_enabled = getattr(sys, '_is_gil_enabled', None)
    if is_enabled is not None and not is_enabled():
        warnings.warn(
            "this Python runs without its global interpreter lock, which goalwire's queues lean on: a "
            'wake-up may be lost, and what waits for it may hang. Set PYTHON_GIL=1, or run python -X gil=1 '
            '(docs/explanation/memory-model.md)',
            RuntimeWarning,
            stacklevel=2,
        )


class ContextLike(Protocol):
    """A context, as far as execution needs it."""

    @property
    def shutdown_signal(self) -> ShutdownSignal:
        """The end of the context, and the sleepers that it wakes."""

    def ok(self) -> bool:
        """Tell whether the context is initialised and not shut down."""


_provider: list[Callable[[], ContextLike]] = []


def provide_default_context(provider: Callable[[], ContextLike]) -> None:
    """Set the function that returns the default context; rclpy does so once."""
    _provider[:] = [provider]


def default_context() -> ContextLike:
    """Return the default context. Raises RuntimeError if rclpy was not imported."""
    if not _provider:
        raise RuntimeError('there is no default context: pass context=..., or import rclpy first')
    return _provider[0]()
