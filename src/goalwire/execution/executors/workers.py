"""The workers of a MultiThreadedExecutor: what they run next, and where they sleep."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from goalwire.execution.current_callback import active_executors
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.stop_conditions import StopWhen
from goalwire.execution.executors.worker_pool import WorkerPool
from goalwire.execution.ready_queue import ReadyQueue
from goalwire.execution.waiters import LockWaiter, Waiter, wake_all

if TYPE_CHECKING:
    from goalwire.execution.executors.drain_tracker import DrainTracker
    from goalwire.execution.ready_queue import CallbackSource
    from goalwire.execution.shutdown_signal import ContextLike
    from goalwire.execution.waiters import WireWaiter

_MANY = 8
"""From this number of callbacks in one spin on, the workers read the wire. The spinning thread would have to
wake a worker for each callback. So a call, with 32 in flight, would take 42 us of the client's processor
time; it takes 32 us if the worker that runs the callback has read the wire."""


class Spins:
    """The spins under way, and who waits on the wire meanwhile: their own threads, or the workers."""

    __slots__ = ('_lock', 'by_workers', 'callbacks', 'count', 'reading')

    def __init__(self) -> None:
        self.count = 0
        self.reading: list[Waiter] = []
        """The waiters of the spinning threads that wait on the wire."""
        self.by_workers = 0
        """The number of spins whose threads do not wait on the wire, so that the workers have to."""
        self.callbacks = 0
        """The number of callbacks since a thread began to wait on the wire. Two workers that count at once
        may count one.
        """
        self._lock = threading.Lock()

    def begin(self, waiter: Waiter, *, reads: bool) -> None:
        """Note a spin; with `reads` its thread waits on the wire, in `waiter`."""
        with self._lock:
            self.count += 1
            if reads:
                self.callbacks = 0
                self.reading.append(waiter)
            else:
                self.by_workers += 1

    def end(self, waiter: Waiter) -> bool:
        """Note the end of a spin; True if its thread was the one that waited on the wire."""
        with self._lock:
            self.count -= 1
            reads = waiter in self.reading
            if reads:
                self.reading.remove(waiter)
            else:
                self.by_workers -= 1
        return reads

    def leave_to_workers(self) -> None:
        """Have the workers read the wire in place of the spinning threads, for the rest of these spins."""
        with self._lock:
            reading, self.reading = self.reading, []
            self.by_workers += len(reading)
        wake_all(reading)

    def reset_in_child(self) -> None:
        """In a forked child, make a new lock: a thread of the parent may hold the old one."""
        self._lock = threading.Lock()


class Workers(Executor):
    """The workers' part of MultiThreadedExecutor."""

    def __init__(self, num_threads: int, context: ContextLike | None) -> None:
        super().__init__(context=context)
        self._pool = WorkerPool(num_threads, self._serve, self._wake_all)
        self._handed_over = ReadyQueue()
        self._spins = Spins()
        self._drains: list[DrainTracker] = []
        self._asleep: list[Waiter] = []
        """The workers that sleep at the ready queue, the last to fall asleep at the end."""
        self._watcher: Waiter | None = None
        self._wanted, self._unwanted = StopWhen(self._is_wanted), StopWhen(self._is_unwanted)
        self._misplaced = StopWhen(self._is_misplaced)

    def reset_in_child(self) -> None:
        super().reset_in_child()
        self._spins.reset_in_child()
        self._pool.reset_in_child()

    def _wake_all(self) -> None:
        self._ready.wake_all()
        self._handed_over.wake_all()

    # -- what others ask of the workers

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

    def _leaves_work(self) -> bool:
        """Tell whether the last spin leaves work, timers or descriptors, for which others may sleep here.

        A worker that was woken for this work does nothing without a spin. So the end of the spin wakes all
        others, such as a thread in `spin_once`, and they look themselves.
        """
        ready = self._ready
        return bool(
            ready.has_work or self._fd_selector.watched or (self._watcher is None and self._timer_heap.heap)
        )

    def _send_somebody(self) -> None:
        """Have a worker look at the queues: wake one, or start one if none sleeps."""
        if self._handed_over.sleepers:
            self._handed_over.wake_one()
        elif not self._wake_worker():
            self._pool.start_worker()

    def _wake_worker(self) -> bool:
        """Wake the worker that fell asleep last at the ready queue; False if none sleeps there."""
        wakers = self._ready.wakers
        for waiter in reversed(self._asleep.copy()):
            try:
                wakers.remove(waiter.wake)
            except ValueError:
                continue  # another thread has woken this worker, for other work
            waiter.wake()
            return True
        return False

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
            if source is None and self._spins.count:
                source = self._next()
            if source is not None:
                self._run_callback(source, thread)
                continue
            taking.discard(thread)
            if self._drains:
                self._tell_none_taken(thread)
            if self._spins.count:
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
        return bool(self._spins.count) or self._retires()

    def _run_callback(self, source: CallbackSource, thread: threading.Thread) -> None:
        try:
            self._keep_watch()  # before `busy`: another worker may take long to start, as if the callback did
        except BaseException as error:  # no further thread can start: the spinning thread raises the error
            self._fail(error)
        # The worker enters `busy`, then leaves `taking`: so at each moment it is in at least one of them. An
        # error is noted before the worker leaves `busy`, so a spin that waits for the worker finds it.
        busy = self._pool.busy
        busy[thread] = source
        self._pool.taking.discard(thread)
        if self._drains:
            self._tell_begun(thread, source)
        self._spins.callbacks += 1
        performed = True
        try:
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
        if not self._spins.count:
            if self._handed_over.items:
                self._send_somebody()  # two threads in `spin_once` have woken the calling worker alone
            return
        # Threads in `spin_once`, or in a spin inside a callback, may sleep at the queue, too. They do not
        # count, since they wake no worker when they leave.
        if not self._asleep:
            self._send_somebody()
        elif self._watcher is None and (self._timer_heap.heap or self._fd_selector.watched):
            self._wake_worker()

    def _sleep_at_queue(self, waiter: WireWaiter, on_lock: LockWaiter) -> None:
        """Sleep at the ready queue: on the wire in `waiter` if the workers read it, else on the lock."""
        if self._spins.callbacks >= _MANY and self._spins.reading:
            self._spins.leave_to_workers()
            self._ready.wake_all()  # the workers that sleep on their locks go on to the wire
        place = waiter if self._spins.by_workers else on_lock
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
        if not self._spins.count:
            self._ready.wake_all()  # the others look, too: a spin_once may wait here for this wake-up

    def _is_unwanted(self) -> bool:
        return not self._spins.count or bool(self._handed_over.items) or self._retires()

    def _is_misplaced(self) -> bool:
        return bool(self._spins.by_workers) or self._is_unwanted()

    def _pass_on(self) -> None:
        """Have another worker look if the work is left for which the calling worker was woken."""
        if self._ready.has_work:
            self._ready.wake_one()
        if self._handed_over.items:
            self._send_somebody()

    def _look_again(self) -> None:
        watcher = self._watcher
        if not self._spins.count:
            self._ready.wake_all()  # the workers that sleep there leave; a spin_once reads the timers anew
        elif watcher is None:
            self._ready.wake_one()
        else:
            watcher.wake()
