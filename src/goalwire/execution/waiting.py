"""How threads sleep and are woken, and the shutdown signal, which wakes all of them.

Every wait here follows one rule. So no wake-up is lost although no lock is held:

- the sleeper first puts its `wake` on a list, then looks whether what it waits for is there;
- the waking thread first puts the thing there, then looks at the list.

So at least one of the two sees the other. docs/explanation/memory-model.md says what this relies on.
"""

from __future__ import annotations

import sys
import warnings
from _thread import allocate_lock
from collections.abc import Callable, Iterable
from threading import TIMEOUT_MAX, current_thread, get_ident, main_thread
from typing import TYPE_CHECKING, Any, Protocol, TypeVar
from weakref import ReferenceType, ref

from goalwire.execution.monotonic import STEADY, SteadyClock

if TYPE_CHECKING:
    import asyncio

    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.execution.fd_selector import FdSelector
    from goalwire.transport.contract import Session

L = TypeVar('L')


class Waiter:
    """A place for one thread to sleep in.

    It holds at most one wake-up: a `wake` that comes first ends the next `wait` at once, and several count
    as one. So whoever waits looks again at what it waits for, each time. In the main thread a sleep is
    interrupted by signal handlers, and by what they raise.
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
        """End the current or the next `wait`. Any thread, signal handlers too; takes no lock."""
        try:
            self._gate.release()
        except RuntimeError:
            return  # the wake-up before this one has not been used yet


def wake_all(waiters: Iterable[Waiter]) -> None:
    """Wake all waiters. Other threads may change the collection meanwhile."""
    for waiter in tuple(waiters):
        waiter.wake()


class WeakListeners(dict[ReferenceType[L], None]):
    """Listeners, held weakly, in the order in which they were added.

    Any thread may add and discard, also while others go through them: each step is one operation of a dict.
    """

    __slots__ = ()

    def add(self, listener: L) -> None:
        """Add a listener. Adding it twice is harmless."""
        self[ref(listener, self._discard_reference)] = None

    def discard(self, listener: L) -> None:
        """Remove a listener; nothing happens if it is not there."""
        self.pop(ref(listener), None)

    def alive(self) -> list[L]:
        """Return the objects that still live."""
        # Python 3.11 may collect garbage while it makes a tuple of a dict, which then changes: so a list.
        found = []
        for reference in list(self):
            listener = reference()
            if listener is not None:
                found.append(listener)
        return found

    def _discard_reference(self, reference: ReferenceType[L]) -> None:
        self.pop(reference, None)


class StopCondition(Protocol):
    """A condition that ends a spin or a wait: a future of ours, or one made by `stop_condition_of`."""

    @property
    def completion_state(self) -> object:
        """True once the awaited event has come.

        hot path: an attribute of futures, since a call would cost 0.6 us with each look after a sleep.
        """

    def add_waker(self, waker: Callable[[], None]) -> None:
        """Have `waker` called once the event has come. Does nothing if others wake the sleeper."""

    def remove_waker(self, waker: Callable[[], None]) -> None:
        """Remove a waker."""


class SignalReceiver(Protocol):
    """Receives the process's signals, whatever the main thread is doing."""

    main_thread: int
    """The main thread's ident."""

    wire_poller: WirePoller | None
    """The wait on the wire in which the main thread is, if it is: a signal ends that wait."""

    def hears(self) -> bool:
        """Whether the calling thread runs signal handlers."""


LISTENING: list[SignalReceiver] = []
"""The receiver of this process, if there is one."""

SHORT_NS = 50_000_000
"""How long the main thread waits on the wire without having seen that signals would bring it out: that is how
long they may wait. The look costs 5 us (two system calls), so it is for long sleeps."""


class WireWaiter(Waiter):
    """A waiter whose thread waits on the wire itself, if the context's session has a place for it.

    Where `fd_selector` watches file descriptors and nobody else waits in it, this waits there. The shutdown
    wakes it, too.
    """

    __slots__ = ('__weakref__', '_fd_selector', '_shutdown_signal', 'interrupt')

    wait_on_lock = Waiter.wait
    """Sleep on the lock, whatever the wire does."""

    def __init__(self, shutdown_signal: ShutdownSignal, fd_selector: FdSelector | None = None) -> None:
        super().__init__()
        self.interrupt: Callable[[], None] | None = None
        """Ends this thread's sleep if it sleeps elsewhere than on its lock."""
        self._shutdown_signal = shutdown_signal
        self._fd_selector = fd_selector
        shutdown_signal.wake_at_end(self)

    def wait(self, timeout_ns: int | None = None) -> bool:
        # hot path: one function for the common cases, 2 calls less (1.2 us) with each sleep of an executor.
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
        # A signal that came before this line has its handler run before the wait begins.
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
        """Sleep in the main thread, where no signal could interrupt a wait inside the wire's library.

        Python runs signal handlers in the main thread, and not while that is in there.
        """
        try:
            self._shutdown_signal.add_external_sleeper(self)
            return self.wait_on_lock(timeout_ns)
        finally:
            self._shutdown_signal.remove_external_sleeper(self)

    def _wait_on_descriptors(self, fd_selector: FdSelector, timeout_ns: int | None) -> bool:
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
        # hot path: as the base class, in one call (0.6 us less between a reply and the thread that waits).
        # A thread that sleeps elsewhere sets `interrupt` first, then looks at the lock: one sees the other.
        try:
            self._gate.release()
        except RuntimeError:
            return
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()


class ShutdownWatch:
    """A registered listener of a shutdown signal."""

    __slots__ = ('_watchers', 'wake')

    def __init__(self, watchers: dict[ShutdownWatch, None], wake: Callable[[], None]) -> None:
        self._watchers = watchers
        self.wake = wake
        """The function that is called at the end."""
        watchers[self] = None

    def close(self) -> None:
        """Stop watching."""
        self._watchers.pop(self, None)


class Alarms(Protocol):
    """A thread that calls timer entries when they are due: `TimerThread`."""

    def set(self, entry: Any, due: int) -> None:
        """Call `entry` at `due`, in ns of the steady clock."""

    def discard(self, entry: Any) -> None:
        """Do not call `entry`."""


class ShutdownSignal:
    """Ends once, for whatever reason. `clock` is the time that everything under this context lives in."""

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
        'wire_poller',
    )

    def __init__(self, clock: SteadyClock = STEADY) -> None:
        self.clock = clock
        self.alive = True
        self.alarms: Alarms | None = None
        """Where looks at spins that last are set, if the context has such a thread."""
        self.early_looks: list[Callable[[], object]] = []
        """Called once, when a spin without end has gone on for seconds: the program has made its nodes."""
        self.reason: str | None = None
        self.wire_poller: WirePoller | None = None
        """Where threads under this may wait on the wire, once there is a session that lets them."""
        self.idle_waiters: list[Waiter] = []
        """As many as have blocked at the same time; see `borrow_waiter`."""
        self.external_sleepers: set[object] = set()
        """Sleepers that do not wait on the wire themselves: asyncio loops, watchers of descriptors."""
        self._watchers: dict[ShutdownWatch, None] = {}
        self._waiters: WeakListeners[WireWaiter] = WeakListeners()
        self._session: Session | None = None

    def take_session(self, session: Session) -> None:
        """Let threads under this wait on a session's wire, as far as it has a place for that.

        When this ends, nothing more is sent by that session. Warns if Python runs without a GIL.
        """
        _warn_without_gil()
        wire_poller = session.wire_poller
        if wire_poller is not None:
            wire_poller.external_sleepers = self.external_sleepers
            self.wire_poller = wire_poller
        self._session = session  # then look at `alive`: `end` clears it first and then looks here
        if not self.alive:
            session.silence()

    def add_external_sleeper(self, who: object) -> None:
        """Have the session's own thread wait on the wire until `remove_external_sleeper`. Any thread."""
        self.external_sleepers.add(who)
        if self.wire_poller is not None:
            self.wire_poller.ensure_polled()

    def remove_external_sleeper(self, who: object) -> None:
        """Undo `add_external_sleeper`; nothing if it was not called."""
        self.external_sleepers.discard(who)

    def new_waiter(self) -> Waiter:
        """Return a place for one thread to sleep in while it waits for the wire.

        The context's end wakes it.
        """
        return WireWaiter(self)

    def borrow_waiter(self) -> Waiter:
        """The same for a short while: it goes back to `idle_waiters`. To make one takes five calls.

        The last owner may still wake it: look again at your condition, as after every wake-up.
        """
        try:
            return self.idle_waiters.pop()
        except IndexError:
            return WireWaiter(self)

    def wake_at_end(self, waiter: WireWaiter) -> None:
        """Wake `waiter`, held weakly, when this ends: for all its life, while a watch is for one sleep."""
        self._waiters.add(waiter)

    def end(self, reason: str) -> bool:
        """End it and tell everybody; False if it has ended before. Takes no lock: signal handlers call it."""
        if not self.alive:
            return False
        self.reason = reason
        self._silence()  # first: whatever sees that this has ended relies on it
        self.alive = False
        self._silence()  # silence a session that was opened meanwhile
        self._session = None
        self._tell()
        return True

    def end_in_child(self, reason: str) -> None:
        """End in a forked child, and tell nobody: the threads that wait are the parent's."""
        self.reason = reason
        self.alive = False
        self._session = None

    def watch(self, wake: Callable[[], None]) -> ShutdownWatch:
        """Call `wake` once when this ends; at once if it has ended.

        It may run on any thread and inside a signal handler: it must only wake somebody, and take no lock.
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
        while self._watchers:
            try:
                watch, _ = self._watchers.popitem()
            except KeyError:
                break
            watch.wake()
        wake_all(self._waiters.alive())


def _warn_without_gil() -> None:
    """Say what does not hold there. Asked once a session is open: what that imports may have turned it on."""
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
        """Whether the context is up, and the sleepers that its end wakes."""

    def ok(self) -> bool:
        """Whether it is initialised and not shut down."""


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
    """The asyncio loop that runs on this thread; does not import asyncio to find out."""
    # Another thread may be in the middle of importing it: then no loop runs yet.
    get: Callable[[], asyncio.AbstractEventLoop | None] | None
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else get()
