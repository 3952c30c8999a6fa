"""MultiThreadedExecutor: callbacks run on its own threads, in parallel if their groups allow it."""

from __future__ import annotations

import os
import threading
import warnings
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException
from goalwire.execution.current import active_executors
from goalwire.execution.drain_tracker import DrainTracker
from goalwire.execution.executor import Executor, Timeout
from goalwire.execution.monotonic import STEADY, deadline_after
from goalwire.execution.ready_queue import ReadyQueue
from goalwire.execution.spin_watch import SpinWatch, of_pool
from goalwire.execution.spinning import (
    NEVER,
    StopConditionScope,
    StopWhen,
    stop_condition_of,
)
from goalwire.execution.waiting import LockWaiter, StopCondition, Waiter, WireWaiter, wake_all
from goalwire.execution.worker_pool import WorkerPool

if TYPE_CHECKING:
    from goalwire.execution.future import Future
    from goalwire.execution.ready_queue import CallbackSource
    from goalwire.execution.waiting import ContextLike


_FEWEST_THREADS = 8
"""The least default limit. Threads are started on demand, and blocked threads cost nothing."""

_MANY = 8
"""From this number of callbacks in one spin on, the workers read the wire. The spinning thread would have to
wake a worker for each callback. So a call, with 32 in flight, would take 42 us of the client's processor
time; it takes 32 us if the worker that runs the callback has read the wire."""

_PATIENCE = 100_000_000
"""In ns: a spin whose future is settled stops waiting after no callback has ended for this time."""


class MultiThreadedExecutor(Executor):
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
        super().__init__(context=context)
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
        self._pool = WorkerPool(num_threads, self._serve, self._wake_all)
        self._handed_over = ReadyQueue()
        self._spins = 0
        self._reading: list[Waiter] = []
        """The waiters of the spinning threads that wait on the wire."""
        self._read_by_workers = 0
        """The number of spins whose threads do not wait on the wire, so that the workers have to."""
        self._taken = 0
        """The number of callbacks since a thread began to wait on the wire. Two workers that count at once
        may count one."""
        self._spins_lock = threading.Lock()
        self._coordinators: list[Waiter] = []
        self._drains: list[DrainTracker] = []
        self._asleep: list[Waiter] = []
        """The workers that sleep at the ready queue, the last to fall asleep at the end."""
        self._watcher: Waiter | None = None
        self._wanted, self._unwanted = StopWhen(self._is_wanted), StopWhen(self._is_unwanted)
        self._misplaced = StopWhen(self._is_misplaced)

    def reset_in_child(self) -> None:
        super().reset_in_child()
        self._spins_lock = threading.Lock()
        self._pool.reset_in_child()

    def spin(self) -> None:
        find = of_pool(self._pool, self._ready, self._timer_heap)
        watch = SpinWatch(self._shutdown_signal, find)
        try:
            self._run(None, None, once=False)
        finally:
            watch.close()

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
        """Tell whether a thread spins this executor, or a callback of it still runs."""
        return bool(self._coordinators or self._spins or self._pool.busy)

    def thread_waits_alone(self) -> bool:
        """Tell whether the calling thread is the only one that may run this executor's callbacks."""
        return self._pool.limit <= 1 and self in active_executors.executors

    def add_capacity(self, count: int) -> None:
        """Allow `count` more threads, in place of those that block in goalwire's calls; a negative `count`
        takes them back.
        """
        with self._spins_lock:
            self._pool.limit += count
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
                self._open(waiter, endless=endless)
                try:
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
                return
            if not self._wait(waiter, deadline):
                return

    def _wait(self, waiter: Waiter, deadline: int | None) -> bool:
        """Wait until woken (True) or until `deadline` (False), on the wire unless the workers read it."""
        if isinstance(waiter, WireWaiter) and waiter not in self._reading and self._clock is STEADY:
            return waiter.wait_on_lock(None if deadline is None else deadline - STEADY.now())
        return self._clock.wait(waiter, deadline)

    def _await_drain(self, waiter: Waiter, deadline: int | None) -> None:
        """Let the workers run the work that has come by now, but do not wait for callbacks that block."""
        # The tracker is in `_drains` before it gathers: workers report each change that comes after its look.
        # A callback may block for ever, so the wait ends if no callback has ended for _PATIENCE.
        drain = DrainTracker(waiter.wake)
        self._drains.append(drain)
        try:
            drain.gather(self._ready, self._pool)
            while not (drain.over or self._is_shutdown or self._is_past(deadline)):
                if not self._shutdown_signal.alive:
                    return
                ended = drain.ended
                give_up = self._clock.now() + _PATIENCE
                until = give_up if deadline is None else min(give_up, deadline)
                if not self._wait(waiter, until) and drain.ended == ended:
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

    def _open(self, waiter: Waiter, *, endless: bool) -> None:
        with self._spins_lock:
            self._spins += 1
            if endless:
                self._read_by_workers += 1
            else:
                self._taken = 0
                self._reading.append(waiter)
        if endless:
            self._ready.wake_all()  # the workers that sleep on their locks go on to the wire
            self._send_somebody()
        elif self._needs_a_look():
            self._send_somebody()

    def _close(self, waiter: Waiter) -> None:
        with self._spins_lock:
            self._spins -= 1
            reads = waiter in self._reading
            if reads:
                self._reading.remove(waiter)
            else:
                self._read_by_workers -= 1
        # The workers leave the wire, or the descriptors, of which they are to read nothing any more.
        if not (reads or self._read_by_workers) or (self._fd_selector.watched and not self._spins):
            self._ready.wake_all()

    def _take_over(self) -> None:
        """Have the workers read the wire in place of the spinning threads, for the rest of these spins."""
        with self._spins_lock:
            reading, self._reading = self._reading, []
            self._read_by_workers += len(reading)
        wake_all(reading)

    def _needs_a_look(self) -> bool:
        """Tell whether a spin that begins needs a worker that looks at the queues.

        It does not if a worker sleeps at the ready queue, and a post there is all that can make work.
        """
        ready = self._ready
        return bool(
            not self._asleep
            or ready.items
            or ready.pollers
            or self._handed_over.items
            or self._fd_selector.watched
            or (self._watcher is None and self._timer_heap.heap)
        )

    def _send_somebody(self) -> None:
        """Have a worker look at the queues: wake one, or start one if none sleeps."""
        if self._handed_over.sleepers:
            self._handed_over.wake_one()
            return
        wakers = self._ready.wakers
        for waiter in reversed(self._asleep.copy()):
            try:
                wakers.remove(waiter.wake)
            except ValueError:
                continue  # another thread has woken this worker, for other work
            waiter.wake()
            return
        self._pool.start_worker()

    def _fail(self, error: BaseException) -> None:
        super()._fail(error)
        wake_all(self._coordinators)

    # -- the workers

    def _serve(self) -> None:
        """A worker's loop: run ready work until the worker has to end."""
        waiter, on_lock = self._new_waiter(), LockWaiter(self._shutdown_signal)
        thread, handed_over, taking = threading.current_thread(), self._handed_over, self._pool.taking
        active_executors.executors.append(self)
        while not (self._retires() and self._leaves()):
            # The worker enters `taking` before it looks at the queues, so that an ending spin knows of it:
            # see DrainTracker.
            taking.add(thread)
            source = handed_over.pop() if handed_over.items else None
            if source is None and self._spins:
                source = self._next()
            if source is not None:
                self._ensure_polled(source, thread)
                continue
            taking.discard(thread)
            if self._drains:
                self._tell_none_taken(thread)
            if self._spins:
                self._sleep_at_queue(waiter, on_lock)
            else:
                handed_over.park(on_lock, self._clock, self._wanted, None)
        self._pass_on()

    def _retires(self) -> bool:
        """Tell whether some worker has to end, perhaps this one. It takes no lock, unlike `_leaves`."""
        pool = self._pool
        return pool.closed or not self._shutdown_signal.alive or len(pool.serving) > pool.limit

    def _leaves(self) -> bool:
        """Tell whether the calling worker has to end. If so, the worker is not counted from here on."""
        pool = self._pool
        return pool.closed or not self._shutdown_signal.alive or pool.retire()

    def _is_wanted(self) -> bool:
        return bool(self._spins) or self._retires()

    def _ensure_polled(self, source: CallbackSource, thread: threading.Thread) -> None:
        # The worker enters `busy`, then leaves `taking`: so at each moment it is in at least one of them. An
        # error is noted before the worker leaves `busy`, so a spin that waits for the worker finds it.
        busy = self._pool.busy
        busy[thread] = source
        self._pool.taking.discard(thread)
        if self._drains:
            self._tell_begun(thread, source)
        self._taken += 1
        performed = True
        try:
            self._keep_watch()
            performed = self._perform(source)
        except BaseException as error:  # the spinning thread raises the error
            self._fail(error)
        finally:
            del busy[thread]
            if self._drains:
                self._tell_ended(thread, source, performed=performed)

    def _tell_none_taken(self, thread: threading.Thread) -> None:
        for drain in tuple(self._drains):
            drain.note_taken(thread)

    def _tell_begun(self, thread: threading.Thread, source: CallbackSource) -> None:
        for drain in tuple(self._drains):
            drain.note_begin(thread, source)

    def _tell_ended(self, thread: threading.Thread, source: CallbackSource, *, performed: bool) -> None:
        for drain in tuple(self._drains):
            drain.note_end(thread, source, performed=performed)

    def _keep_watch(self) -> None:
        """Make sure that another worker sleeps at the queue while the calling worker runs a callback."""
        if not self._spins:
            return
        if not self._ready.wakers:
            self._send_somebody()
        elif self._watcher is None and (self._timer_heap.heap or self._fd_selector.watched):
            self._ready.wake_one()

    def _sleep_at_queue(self, waiter: WireWaiter, on_lock: LockWaiter) -> None:
        """Sleep at the ready queue: on the wire in `waiter` if the workers read it, else on the lock."""
        if self._taken >= _MANY and self._reading:
            self._take_over()
        place = waiter if self._read_by_workers else on_lock
        watches = self._watcher is None and bool(self._timer_heap.heap or self._fd_selector.watched)
        if watches:
            # `_watcher` is set before `watched` is read here, and before `park` reads the timer heap. So a
            # descriptor or a timer that is added in between wakes this worker.
            self._watcher = place
            if self._fd_selector.watched:
                self._watcher = place = waiter
        self._asleep.append(place)
        try:
            self._ready.park(
                place,
                self._clock,
                self._unwanted if place is waiter else self._misplaced,
                None,
                self._timer_heap if watches else None,
                last=watches,
            )
        finally:
            self._asleep.remove(place)
            if watches:
                self._watcher = None
        if not self._spins:
            self._ready.wake_all()  # the others look, too: a spin_once may wait here for this wake-up

    def _is_unwanted(self) -> bool:
        return not self._spins or bool(self._handed_over.items) or self._retires()

    def _is_misplaced(self) -> bool:
        return bool(self._read_by_workers) or self._is_unwanted()

    def _pass_on(self) -> None:
        """Have another worker look if the work is left for which the calling worker was woken."""
        if self._ready.has_work:
            self._ready.wake_one()
        if self._handed_over.items:
            self._send_somebody()

    def _look_again(self) -> None:
        watcher = self._watcher
        if not self._spins:
            self._ready.wake_all()  # the workers that sleep there leave; a spin_once reads the timers anew
        elif watcher is None:
            self._ready.wake_one()
        else:
            watcher.wake()

    def _wake_workers(self) -> None:
        self._pool.close()

    def _wake_all(self) -> None:
        self._ready.wake_all()
        self._handed_over.wake_all()
        wake_all(self._coordinators)
