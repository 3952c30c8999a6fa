"""Waiters: how threads sleep and are woken.

Every wait follows one rule. So no wake-up is lost although no lock is held:

- the sleeper first puts its `wake` on a list, then looks whether the awaited change has happened;
- the waking thread first makes the awaited change, then looks at the list.

So at least one of the two sees the other. docs/explanation/memory-model.md says what this relies on.
"""

from __future__ import annotations

import sys
from _thread import allocate_lock
from collections.abc import Callable, Iterable
from functools import partial
from threading import TIMEOUT_MAX, current_thread, get_ident, main_thread
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import asyncio

    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.execution.asyncio.fd_selector import FdSelector


UNHEARD_NS = 1_000_000_000
"""The longest sleep of the main thread without a listener, as in a program that wants no handlers of ours; it
then sleeps again. A signal that comes just before the sleep, or to another thread, does not end it, and
CPython runs the handler only afterwards. A listener would end the sleep.
"""


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
            if not LISTENING and current_thread() is main_thread():
                return self._wait_unheard(None)
            return self._gate.acquire()
        if timeout_ns <= 0:
            return self._gate.acquire(blocking=False)
        if timeout_ns > UNHEARD_NS and not LISTENING and current_thread() is main_thread():
            return self._wait_unheard(timeout_ns)
        return self._gate.acquire(timeout=min(timeout_ns / 1e9, TIMEOUT_MAX))

    def _wait_unheard(self, left_ns: int | None) -> bool:
        """Sleep until woken or for `left_ns`, with a look for signals every UNHEARD_NS."""
        while left_ns is None or left_ns > UNHEARD_NS:
            if self._gate.acquire(timeout=UNHEARD_NS / 1e9):
                return True
            left_ns = None if left_ns is None else left_ns - UNHEARD_NS
        return self._gate.acquire(timeout=left_ns / 1e9)

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
    for waiter in list(waiters):
        waiter.wake()


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


class WireOfContext(Protocol):
    """The wire of a context, as far as a sleeping thread needs it: `ShutdownSignal`."""

    wire_poller: WirePoller | None
    """The wire on which threads of this context may wait; None before a session allows that."""

    def add_external_sleeper(self, who: object) -> None:
        """Have the session's own thread wait on the wire until `remove_external_sleeper`."""

    def remove_external_sleeper(self, who: object) -> None:
        """Undo `add_external_sleeper`."""

    def wake_at_end(self, waiter: WireWaiter) -> None:
        """Have `waiter` woken at the end of the context."""


class WireWaiter(Waiter):
    """A waiter whose thread waits on the wire itself, if the context's session supports that.

    If `fd_selector` watches file descriptors and no other thread waits in it, this thread waits there. The
    shutdown wakes it, too.
    """

    __slots__ = ('__weakref__', '_fd_selector', '_shutdown_signal', 'interrupt', 'take_wake')

    wait_on_lock = Waiter.wait
    """Sleep on the lock, not on the wire."""

    def __init__(self, shutdown_signal: WireOfContext, fd_selector: FdSelector | None = None) -> None:
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


def running_loop() -> asyncio.AbstractEventLoop | None:
    """Return the asyncio loop that runs on this thread, or None, without importing asyncio."""
    # If another thread is in the middle of importing asyncio, no loop runs yet.
    get: Callable[[], asyncio.AbstractEventLoop | None] | None
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else get()
