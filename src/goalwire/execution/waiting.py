"""How a thread sleeps until somebody wakes it."""

from __future__ import annotations

from _thread import allocate_lock
from threading import TIMEOUT_MAX, current_thread, get_ident, main_thread
from typing import TYPE_CHECKING

from goalwire.execution.signal_listener import LISTENING

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.fd_selector import FdSelector
    from goalwire.execution.shutdown_signal import ShutdownSignal


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


SHORT_NS = 50_000_000
"""How long the main thread waits on the wire without having seen that signals would bring it out: that is how
long they may wait. The look costs 5 us (two system calls), so it is for long sleeps."""


class WireWaiter(Waiter):
    """A waiter whose thread waits on the wire itself, where the context's session has a place for it.

    The shutdown wakes it.
    """

    __slots__ = ('__weakref__', '_shutdown_signal', 'interrupt')

    wait_on_lock = Waiter.wait
    """Sleep on the lock, whatever the wire does."""

    _fd_selector: FdSelector | None = None
    """What else it watches while it sleeps."""

    def __init__(self, shutdown_signal: ShutdownSignal) -> None:
        super().__init__()
        self.interrupt: Callable[[], None] | None = None
        """What ends this thread's sleep, where it sleeps elsewhere than on its lock."""
        self._shutdown_signal = shutdown_signal
        shutdown_signal.wake_at_end(self)

    def wait(self, timeout_ns: int | None = None) -> bool:
        # All of it in one function, for the common cases: it begins and ends each sleep of an executor.
        if self._fd_selector is not None and self._fd_selector.watched:
            return self._wait_on_descriptors(timeout_ns)
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
        """Sleep in the main thread where no signal would bring it out of the wire's library.

        Python runs signal handlers in the main thread, and not while that is in there.
        """
        try:
            self._shutdown_signal.add_external_sleeper(self)
            return self.wait_on_lock(timeout_ns)
        finally:
            self._shutdown_signal.remove_external_sleeper(self)

    def _wait_on_descriptors(self, timeout_ns: int | None) -> bool:
        raise NotImplementedError

    def wake(self) -> None:
        # Who sleeps elsewhere says so first, then looks at the lock: one of the two sees the other.
        try:
            self._gate.release()
        except RuntimeError:
            return
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()
