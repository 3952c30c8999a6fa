"""Chooses the callback that runs next, and sleeps until there is one. All executors share it."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import ref

from goalwire.errors import ExternalShutdownException
from goalwire.execution.asyncio.fd_selector import FdSelector
from goalwire.execution.ready_queue import NodeWorkQueue, ReadyQueue
from goalwire.execution.time.timer_heap import TimerHeap
from goalwire.execution.waiters import WireWaiter
from goalwire.execution.weak_methods import weakly

if TYPE_CHECKING:
    from goalwire.execution.ready_queue import CallbackSource
    from goalwire.execution.shutdown_signal import ShutdownSignal
    from goalwire.execution.waiters import StopCondition


class CallbackChooser:
    """Finds the work that is ready, in the order in which it was posted.

    Timers, file descriptors and waitables post their work when they are asked, which happens before each
    choice.
    """

    def __init__(self, shutdown_signal: ShutdownSignal) -> None:
        self._shutdown_signal = shutdown_signal
        self._clock = shutdown_signal.clock
        # The wire refers to the ready queue and the timer heap through the nodes' queues. So these two refer
        # to the executor only weakly: otherwise the wire would keep the executor and its nodes alive.
        self._ready = ReadyQueue(ref(self))
        self._timer_heap = TimerHeap(weakly(self._look_again), self._ready.wakers)
        self._fd_selector = FdSelector(self._look_again)
        self._is_shutdown = False
        self.work_queue = NodeWorkQueue()
        """The queue of the executor's own tasks."""
        self.work_queue.attach(self._ready, self._timer_heap)

    def reset_in_child(self) -> None:
        """In a forked child, forget the sleeping threads: they are the parent's."""
        self._timer_heap.reset_in_child()
        self._fd_selector.reset_in_child()

    def is_driven(self) -> bool:
        """Tell whether a thread may be spinning this executor. A program's own subclass counts as spinning
        until its shutdown.
        """
        return not self._is_shutdown

    def _look_again(self) -> None:
        """Wake a sleeper, because of an earlier timer or a new descriptor to watch."""
        self._ready.wake_one()

    def _next(self) -> CallbackSource | None:
        """Return the next ready work, or None, after a look at timers, file descriptors and waitables."""
        ready = self._ready
        if self._timer_heap.earliest is not None or self._fd_selector.watched or ready.pollers:
            self._look_around()
        if ready.items:
            try:
                return ready.items.popleft()
            except IndexError:
                return None  # another thread has taken the last work
        return None

    def _look_around(self) -> None:
        """Let the timers, file descriptors and waitables that are ready post their work."""
        earliest = self._timer_heap.earliest
        if earliest is not None and earliest <= (now := self._clock.now()):
            self._timer_heap.call_due(now)
        if self._fd_selector.watched:
            self._fd_selector.poll()
        if self._ready.pollers:
            self._ready.poll_waitables()

    def _is_past(self, deadline: int | None) -> bool:
        return deadline is not None and deadline <= self._clock.now()

    def _new_waiter(self) -> WireWaiter:
        return WireWaiter(self._shutdown_signal, self._fd_selector)

    def _take(self, waiter: WireWaiter, stop: StopCondition, deadline: int | None) -> CallbackSource | None:
        """Return the next ready work, after sleeping for it; None at `stop`, at shutdown and at `deadline`.

        Raises ExternalShutdownException when the context has ended.
        """
        ready, fd_selector, timer_heap = self._ready, self._fd_selector, self._timer_heap
        while not self._is_shutdown:
            if not self._shutdown_signal.alive:
                raise ExternalShutdownException
            # hot path: the bodies of `_next` and `_look_around`, since their calls would take 1.8 us a sleep.
            due = timer_heap.earliest
            if due is not None and due <= (now := self._clock.now()):
                timer_heap.call_due(now)
            if fd_selector.watched or ready.pollers:
                self._look_around()
            if ready.items:
                try:
                    return ready.items.popleft()
                except IndexError:
                    continue  # another thread has taken the last work
            if stop.completion_state or (deadline is not None and deadline <= self._clock.now()):
                return None
            self._ready.park(waiter, self._clock, stop, deadline, self._timer_heap)
        return None
