"""How threads sleep and are woken, and the shutdown signal, which wakes all of them.

Every wait here follows one rule. So no wake-up is lost although no lock is held:

- the sleeper first puts its `wake` on a list, then looks whether the awaited change has happened;
- the waking thread first makes the awaited change, then looks at the list.

So at least one of the two sees the other. docs/explanation/memory-model.md says what this relies on.
"""

from __future__ import annotations

import signal
import sys
import warnings
from _thread import allocate_lock
from collections.abc import Callable, Iterable
from functools import partial
from threading import TIMEOUT_MAX, current_thread, get_ident, main_thread
from typing import TYPE_CHECKING, Any, Protocol, TypeVar
from weakref import ReferenceType, ref

from goalwire.errors import ShutDownBySignalError, ShutDownError
from goalwire.execution.monotonic import STEADY, SteadyClock

if TYPE_CHECKING:
    import asyncio

    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.execution.fd_selector import FdSelector
    from goalwire.transport.contract import Session

L = TypeVar('L')


class Waiter:
    """A place for one thread to sleep in.

    It holds at most one wake-up: a `wake` before a `wait` ends that `wait` at once, and several count as one.
    So after each wake-up the thread looks again whether its condition is true. In the main thread signal
    handlers run during a sleep, and an error that they raise ends it.
    """

    __slots__ = ('_gate',)

    def __init__(self) -> None:
        self._gate = allocate_lock()
        self._gate.acquire()

    def wait(self, timeout_ns: int | None = None) -> bool:
        """Sleep until woken (True) or for `timeout_ns` (False); None sleeps without limit."""
        if timeout_ns is None:
            return self._gate.acquire()
        if timeout_ns <= 0:
            return self._gate.acquire(blocking=False)
        return self._gate.acquire(timeout=min(timeout_ns / 1e9, TIMEOUT_MAX))

    def wake(self) -> None:
        """End the current or the next `wait`. Callable from any thread and from signal handlers; takes no
        lock.
        """
        try:
            self._gate.release()
        except RuntimeError:
            return  # an earlier wake-up has not been consumed yet


def wake_all(waiters: Iterable[Waiter]) -> None:
    """Wake all waiters. Other threads may change the collection meanwhile."""
    for waiter in tuple(waiters):
        waiter.wake()


class WeakListeners(dict[ReferenceType[L], None]):
    """Listeners, held weakly, in the order in which they were added.

    Any thread may add and discard, also while others go through them: each step is one operation of a dict or
    of a list. The callback of a dead reference is a method of a list, too. In a function of Python, a signal
    handler could raise, as Python's own does for Ctrl-C. Python prints such an error and loses it.
    """

    __slots__ = ('_dead',)

    def __init__(self) -> None:
        super().__init__()
        self._dead: list[ReferenceType[L]] = []
        """The references whose listeners have died. `add` and `alive` remove them."""

    def add(self, listener: L) -> None:
        """Add a listener. Adding it twice is harmless."""
        if self._dead:
            self._remove_dead()
        self[ref(listener, self._dead.append)] = None

    def discard(self, listener: L) -> None:
        """Remove a listener; nothing happens if it is not there."""
        self.pop(ref(listener), None)

    def alive(self) -> list[L]:
        """Return the listeners that still live."""
        if self._dead:
            self._remove_dead()
        # A list and not a tuple: Python 3.11 may collect garbage while it makes a tuple, which changes the
        # dict.
        found = []
        for reference in list(self):
            listener = reference()
            if listener is not None:
                found.append(listener)
        return found

    def _remove_dead(self) -> None:
        dead = self._dead
        while dead:
            try:
                self.pop(dead.pop(), None)
            except IndexError:
                return  # another thread has removed the last one


class StopCondition(Protocol):
    """A condition that ends a spin or a wait: a Future, or a condition that `stop_condition_of` made."""

    @property
    def completion_state(self) -> object:
        """True once the awaited event has come.

        hot path: futures have it as an attribute, since a call would take 0.6 us at each look after a sleep.
        """

    def add_waker(self, waker: Callable[[], None]) -> None:
        """Have `waker` called once the event has come. Some conditions do nothing: other code wakes the
        thread.
        """

    def remove_waker(self, waker: Callable[[], None]) -> None:
        """Remove a waker."""


class SignalReceiver(Protocol):
    """Receives the process's signals, whatever the main thread is doing."""

    main_thread: int
    """The main thread's ident."""

    wire_poller: WirePoller | None
    """The wire on which the main thread waits, if it does. A signal ends that wait."""

    def hears(self) -> bool:
        """Tell whether a signal would end a wait of the main thread on the wire."""


LISTENING: list[SignalReceiver] = []
"""The receiver of this process, if there is one."""

SHORT_NS = 50_000_000
"""The main thread waits this long on the wire before it checks that signals would end the wait. So a signal
may be delayed by this time. The check takes 5 us (two system calls), so short sleeps go without it."""


class WireWaiter(Waiter):
    """A waiter whose thread waits on the wire itself, if the context's session supports that.

    If `fd_selector` watches file descriptors and no other thread waits in it, this thread waits there. The
    shutdown wakes it, too.
    """

    __slots__ = ('__weakref__', '_fd_selector', '_shutdown_signal', 'interrupt', 'take_wake')

    wait_on_lock = Waiter.wait
    """Sleep on the lock, not on the wire."""

    def __init__(self, shutdown_signal: ShutdownSignal, fd_selector: FdSelector | None = None) -> None:
        super().__init__()
        self.take_wake: Callable[[], bool] = partial(self._gate.acquire, False)
        """Consumes an earlier wake-up, without sleeping; False if there was none."""
        self.interrupt: Callable[[], None] | None = None
        """Ends the sleep of a thread that does not sleep on its lock, but on the wire or on descriptors."""
        self._shutdown_signal = shutdown_signal
        self._fd_selector = fd_selector
        shutdown_signal.wake_at_end(self)

    def wait(self, timeout_ns: int | None = None) -> bool:
        # hot path: one function for the common cases, which saves two calls (1.2 us) at each sleep.
        fd_selector = self._fd_selector
        if fd_selector is not None and fd_selector.watched:
            return self._wait_on_descriptors(fd_selector, timeout_ns)
        wire_poller = self._shutdown_signal.wire_poller
        if wire_poller is None or (timeout_ns is not None and timeout_ns <= 0):
            return self.wait_on_lock(timeout_ns)
        if not LISTENING:
            if current_thread() is main_thread():
                return self._wait_on_lock_beside_wire(timeout_ns)
            return wire_poller.wait(self, timeout_ns)
        listener = LISTENING[0]
        if get_ident() != listener.main_thread:
            return wire_poller.wait(self, timeout_ns)
        # Python runs the handler of an earlier signal before the wait begins, so only later ones must end it.
        outer, listener.wire_poller = listener.wire_poller, wire_poller
        try:
            if timeout_ns is not None and timeout_ns <= SHORT_NS:
                return wire_poller.wait(self, timeout_ns)
            if wire_poller.wait(self, SHORT_NS):
                return True
            left = None if timeout_ns is None else timeout_ns - SHORT_NS
            if listener.hears():
                return wire_poller.wait(self, left)
        finally:
            listener.wire_poller = outer
        return self._wait_on_lock_beside_wire(left)

    def _wait_on_lock_beside_wire(self, timeout_ns: int | None) -> bool:
        """Sleep on the lock in the main thread, while the session's own thread waits on the wire.

        Python runs signal handlers only in the main thread, and not during a wait on the wire. Without a
        listener no thread would end such a wait.
        """
        try:
            self._shutdown_signal.add_external_sleeper(self)
            return self.wait_on_lock(timeout_ns)
        finally:
            self._shutdown_signal.remove_external_sleeper(self)

    def _wait_on_descriptors(self, fd_selector: FdSelector, timeout_ns: int | None) -> bool:
        # If another thread waits in the selector, `wanted` asks it to hand over. The second try covers the
        # case that it has left in between. If the selector is still taken, the lock is the place to sleep.
        timeout = None if timeout_ns is None else max(timeout_ns, 0) / 1e9
        try:
            self.interrupt = fd_selector.interrupt
            self._shutdown_signal.add_external_sleeper(self)
            if not fd_selector.wait(timeout, self._is_woken):
                fd_selector.wanted = True
                if not fd_selector.wait(timeout, self._is_woken):
                    self.interrupt = None
                    return self.wait_on_lock(timeout_ns)
        finally:
            self.interrupt = None
            self._shutdown_signal.remove_external_sleeper(self)
        return self.wait_on_lock(0)

    def _is_woken(self) -> bool:
        return not self._gate.locked()

    def wake(self) -> None:
        # hot path: the body of the base class, since a call would take 0.6 us between a reply and its
        # receiver. No wake-up is lost: this releases the lock, then reads `interrupt`. A thread that does not
        # sleep on its lock sets `interrupt`, then looks at the lock.
        try:
            self._gate.release()
        except RuntimeError:
            return
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()


class LockWaiter(WireWaiter):
    """A waiter whose thread leaves the wire to others and sleeps on its lock. The shutdown wakes it, too."""

    __slots__ = ()

    wait = Waiter.wait


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
        self.spin_listeners: WeakListeners[SpinListener] = WeakListeners()
        """Each thread that begins to spin without end calls their `on_spin`."""
        self.reason: str | None = None
        self.wire_poller: WirePoller | None = None
        """The wire on which threads of this context may wait; None before a session allows that."""
        self.idle_waiters: list[Waiter] = []
        """The waiters that `borrow_waiter` may give out again."""
        self.external_sleepers: set[object] = set()
        """Sleepers that do not wait on the wire themselves: asyncio loops, watchers of descriptors."""
        self._watchers: dict[ShutdownWatch, None] = {}
        self._waiters: WeakListeners[WireWaiter] = WeakListeners()
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


def running_loop() -> asyncio.AbstractEventLoop | None:
    """Return the asyncio loop that runs on this thread, or None, without importing asyncio."""
    # If another thread is in the middle of importing asyncio, no loop runs yet.
    get: Callable[[], asyncio.AbstractEventLoop | None] | None
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else get()
