"""How a thread sleeps until somebody wakes it."""

from __future__ import annotations

from _thread import allocate_lock
from threading import TIMEOUT_MAX
from typing import TYPE_CHECKING

from goalwire.execution.signal_listener import in_deaf_main_thread, wait_on_wire

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.lifeline import Lifeline


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


class Keeper(Waiter):
    """A waiter whose thread waits on the wire itself, where the session of `lifeline` has a place for it."""

    __slots__ = ('_lifeline', 'interrupt')

    doze = Waiter.wait
    """Sleep on the lock, whatever the wire does."""

    def __init__(self, lifeline: Lifeline) -> None:
        super().__init__()
        self.interrupt: Callable[[], None] | None = None
        """What ends this thread's sleep, where it sleeps elsewhere than on its lock."""
        self._lifeline = lifeline

    def wait(self, timeout_ns: int | None = None) -> bool:
        lifeline = self._lifeline
        vigil = lifeline.vigil
        if vigil is None or (timeout_ns is not None and timeout_ns <= 0):
            return self.doze(timeout_ns)
        if not in_deaf_main_thread():
            return wait_on_wire(vigil, self, timeout_ns)
        lifeline.depend(self)
        try:
            return self.doze(timeout_ns)
        finally:
            lifeline.depend_no_more(self)

    def wake(self) -> None:
        # Who sleeps elsewhere says so first, then looks at the lock: one of the two sees the other.
        try:
            self._gate.release()
        except RuntimeError:
            return
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()
