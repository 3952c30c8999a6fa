"""MultiThreadedExecutor: callbacks run on its own threads, in parallel if their groups allow it."""

from __future__ import annotations

import os
import warnings
from functools import partial
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException
from goalwire.execution.current_callback import active_executors
from goalwire.execution.executors.drain_tracker import DrainTracker
from goalwire.execution.executors.executor import Timeout
from goalwire.execution.executors.spin_watch import of_pool
from goalwire.execution.executors.stop_conditions import (
    NEVER,
    StopConditionScope,
    stop_condition_of,
)
from goalwire.execution.executors.workers import Workers
from goalwire.execution.time.steady_clock import STEADY, deadline_after
from goalwire.execution.waiters import StopCondition, Waiter, WireWaiter, wake_all

if TYPE_CHECKING:
    from goalwire.execution.future import Future
    from goalwire.execution.shutdown_signal import ContextLike


_FEWEST_THREADS = 8
"""The least default limit. Threads are started on demand, and blocked threads cost nothing."""

_PATIENCE = 100_000_000
"""In ns: a spin whose future is settled stops waiting if no callback begins or ends for this time while one
runs, which may block for ever."""
_STARTS = 10
"""It waits this many times as long while none runs: on a busy machine a worker may take that long to come."""


class MultiThreadedExecutor(Workers):
    """Runs callbacks on workers, which take ready work from one queue. The spinning thread only waits.

    Before a worker runs a callback, it makes sure that another worker sleeps at the queue, and starts one if
    there is none. One sleeper, the watcher, also waits for the next timer and for the file descriptors.

    A thread that spins until a future is done waits on the wire itself, and the reply that completes the
    future wakes no other thread. The workers then sleep on their locks. During `spin`, and in a spin that
    brings many callbacks, the workers wait on the wire: so a message wakes the worker that runs its callback,
    and no other thread before it.

    A worker that sleeps at the queue at the end of a spin sleeps on, and the next spin finds it there. If it
    is woken while no thread spins, it goes to the queue `_handed_over`, into which `spin_once` puts its
    callback.
    """

    _spread_runners = True

    def __init__(self, num_threads: int | None = None, *, context: ContextLike | None = None) -> None:
        """Make an executor with up to `num_threads` threads; None: one for each processor, at least 8.

        Raises ValueError for less than one.
        """
        if num_threads is None:
            num_threads = max(os.cpu_count() or 1, _FEWEST_THREADS)
        if num_threads <= 0:
            raise ValueError('max_workers must be greater than 0')
        if num_threads == 1:
            warnings.warn(
                'MultiThreadedExecutor is used with a single thread.\n'
                'Use the SingleThreadedExecutor instead.',
                stacklevel=2,
            )
        super().__init__(num_threads, context)
        self._coordinators: list[Waiter] = []

    def spin(self) -> None:
        self._spin_without_end(may_wait=False)

    def spin_or_wait(self) -> None:
        self._spin_without_end(may_wait=True)

    def _spin_without_end(self, *, may_wait: bool) -> None:
        if self in active_executors.executors:  # a callback on one of the workers spins
            may_wait = True
        find = of_pool(self._pool, self._ready, self._timer_heap)
        spin = partial(self._run, None, None, once=False)
        self._endless_spins.watch(spin, self._shutdown_signal, find, may_wait=may_wait)

    def spin_until_future_complete(self, future: Future[Any], timeout_sec: Timeout = None) -> None:
        self._run(future, self._deadline(timeout_sec), once=False)

    def shutdown(self, timeout_sec: float | None = None, *, wait_for_threads: bool = False) -> bool:
        """End every spin and remove the nodes.

        With `wait_for_threads` it waits until the running callbacks and all threads but the calling one have
        ended; False if `timeout_sec` passes before that. None and negative values wait without limit.
        """
        super().shutdown(timeout_sec)
        if not wait_for_threads:
            return True
        if timeout_sec is None or timeout_sec < 0:
            return self._pool.await_end(None)
        return self._pool.await_end(deadline_after(STEADY, timeout_sec))

    def is_driven(self) -> bool:
        """Tell whether a thread spins this executor. A callback that still runs after the last spin does not
        count: no other callback comes after it.
        """
        return bool(self._coordinators or self._spins.count)

    @property
    def is_spinning(self) -> bool:
        """True if a thread spins this executor, or a callback of it still runs."""
        return self.is_driven() or bool(self._pool.busy)

    def thread_waits_alone(self) -> bool:
        """Tell whether the calling thread is the only one that may run this executor's callbacks."""
        return self._pool.limit <= 1 and self in active_executors.executors

    def add_capacity(self, count: int) -> None:
        """Allow `count` more threads, in place of those that block in goalwire's calls; a negative `count`
        takes them back.
        """
        self._pool.raise_limit(count)
        if count > 0:
            self._keep_watch()

    # -- the thread that spins

    def _run(self, until: Future[Any] | None, deadline: int | None, *, once: bool) -> None:
        self.has_spun = True
        stop = stop_condition_of(until)
        if stop.completion_state and self._has_nothing_left(once=once):
            return
        try:
            if self in active_executors.executors:
                self._run_nested(stop, deadline, once=once)
            elif once:
                self._hand_over(stop, deadline)
            else:
                self._coordinate(stop, deadline)
        except ExternalShutdownException:
            return  # as in rclpy, spin returns without an error
        finally:
            if not self._shutdown_signal.alive:
                self._close_runners()

    def _coordinate(self, stop: StopCondition, deadline: int | None) -> None:
        """Let the workers run callbacks, and wait until `stop`, `deadline`, the shutdown or an error."""
        endless = stop is NEVER
        waiter = Waiter() if endless else self._shutdown_signal.borrow_waiter()
        self._coordinators.append(waiter)
        try:
            with StopConditionScope(self._shutdown_signal, waiter, stop):
                self._spins.begin(waiter, reads=not endless)
                try:
                    self._open(endless=endless)
                    self._await_stop(waiter, stop, deadline)
                finally:
                    self._close(waiter)
        finally:
            self._coordinators.remove(waiter)
            if not endless:
                self._shutdown_signal.idle_waiters.append(waiter)

    def _await_stop(self, waiter: Waiter, stop: StopCondition, deadline: int | None) -> None:
        while True:
            self._raise_failure()
            if self._is_shutdown or not self._shutdown_signal.alive:
                return
            if stop.completion_state:
                # These three looks have the order of DrainTracker.gather. If they find nothing, no callback
                # is left for which this spin would have to wait.
                if self._ready.items or self._pool.taking or self._pool.busy:
                    self._await_drain(waiter, deadline)
                else:
                    self._raise_failure()  # the error of a callback that ended after the first look
                return
            if not self._wait(waiter, deadline):
                return

    def _wait(self, waiter: Waiter, deadline: int | None) -> bool:
        """Wait until woken (True) or until `deadline` (False), on the wire unless the workers read it."""
        if isinstance(waiter, WireWaiter) and waiter not in self._spins.reading and self._clock is STEADY:
            return waiter.wait_on_lock(None if deadline is None else deadline - STEADY.now())
        return self._clock.wait(waiter, deadline)

    def _await_drain(self, waiter: Waiter, deadline: int | None) -> None:
        """Let the workers run the work that has come by now, but do not wait for callbacks that block."""
        # The tracker is in `_drains` before it gathers: workers report each change that comes after its look.
        drain = DrainTracker(waiter.wake)
        self._drains.append(drain)
        idle = 0
        try:
            drain.gather(self._ready, self._pool)
            while not (drain.over or self._is_shutdown or self._is_past(deadline)):
                if not self._shutdown_signal.alive:
                    return
                changes = drain.changes
                give_up = self._clock.now() + _PATIENCE
                until = give_up if deadline is None else min(give_up, deadline)
                is_idle = not self._wait(waiter, until) and drain.changes == changes
                idle = idle + 1 if is_idle else 0
                if idle >= (1 if self._pool.busy else _STARTS):
                    return
                self._raise_failure()
            self._raise_failure()  # the error of a callback that ended before the first wait
        finally:
            self._drains.remove(drain)

    def _hand_over(self, stop: StopCondition, deadline: int | None) -> None:
        """Wait for one piece of ready work and give it to a worker."""
        self._raise_failure()
        waiter = self._new_waiter()
        with StopConditionScope(self._shutdown_signal, waiter, stop):
            source = self._take(waiter, stop, deadline)
        if source is not None:
            self._handed_over.post(source)
            self._send_somebody()

    def _open(self, *, endless: bool) -> None:
        if endless:
            self._ready.wake_all()  # the workers that sleep on their locks go on to the wire
            self._send_somebody()
        elif self._needs_a_look():
            self._send_somebody()

    def _close(self, waiter: Waiter) -> None:
        spins, reads = self._spins, self._spins.end(waiter)
        # The workers leave the wire, or the descriptors, of which they are to read nothing any more.
        if not (reads or spins.by_workers) or (not spins.count and self._leaves_work()):
            self._ready.wake_all()

    def _fail(self, error: BaseException) -> None:
        super()._fail(error)
        wake_all(self._coordinators)

    def _wake_workers(self) -> None:
        self._pool.close()

    def _wake_all(self) -> None:
        super()._wake_all()
        wake_all(self._coordinators)
