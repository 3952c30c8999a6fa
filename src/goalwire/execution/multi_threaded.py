"""MultiThreadedExecutor: callbacks run on its own threads, in parallel if their groups allow it."""

from __future__ import annotations

import os
import threading
import warnings
from _thread import allocate_lock
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from goalwire.concurrency.exits import Stage, at_exit
from goalwire.concurrency.snapshots import copy_of
from goalwire.errors import ExternalShutdownException
from goalwire.execution.current import active_executors
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executor import Executor, Timeout
from goalwire.execution.monotonic import STEADY, deadline_after
from goalwire.execution.ready_queue import ReadyQueue
from goalwire.execution.spin_watch import SpinWatch, of_pool
from goalwire.execution.spinning import (
    StopConditionScope,
    StopWhen,
    stop_condition_of,
)
from goalwire.execution.waiting import StopCondition, Waiter, wake_all

if TYPE_CHECKING:
    from collections.abc import Callable
    from threading import Thread

    from goalwire.execution.future import Future
    from goalwire.execution.ready_queue import CallbackSource
    from goalwire.execution.waiting import ContextLike, WireWaiter


class DrainTracker:
    """The work that is ready when a spin's future is settled, and that the spin still waits for.

    Each worker reports the begin and the end of its callbacks. `done` is called after the last callback.
    Tasks and timers whose callbacks run already are not waited for, since such a callback may run for long.

    Work goes from the ready queue to a worker in three steps: the worker enters `taking`, takes the work, and
    enters itself with the work in `busy`. `gather` looks in the same order, so it misses no work.
    """

    def __init__(self, done: Callable[[], None]) -> None:
        self.ended = 0
        """The number of callbacks that have ended since the tracker was made."""
        self._done = done
        self._lock = allocate_lock()
        self._events: dict[CallbackSource, int] = {}  # events whose callbacks have not begun
        self._running: set[Thread] = set()
        self._taking: set[Thread] = set()  # workers that may have taken work, which is not known yet

    def gather(self, ready: ReadyQueue, pool: WorkerPool) -> None:
        """Count the work in `ready`, the work of the workers of `pool`, and the work that waits for those
        workers' groups.
        """
        with self._lock:
            for source in copy_of(ready.items):
                self._count(source)
            self._taking |= pool.taking.copy()
            for thread, source in pool.busy.copy().items():
                if source.group is not None:
                    for parked in source.group.parked:
                        self._count(parked)
                if isinstance(source, EventQueue):
                    self._running.add(thread)
                    self._count(source)

    @property
    def over(self) -> bool:
        """True if all gathered work has been run."""
        return not self._taking and not self._running and not self._events

    def note_begin(self, thread: Thread, source: CallbackSource) -> None:
        """Note that `thread` begins a callback of `source`."""
        with self._lock:
            if thread not in self._running:
                if thread in self._taking and source not in self._events:
                    self._count(source)  # taken out of the queue just before `gather` looked there
                if source in self._events:
                    self._running.add(thread)
                    self._take_one(source)
        self.note_taken(thread)  # called last, since `over` is read without the lock

    def note_taken(self, thread: Thread) -> None:
        """Note that `thread` has taken its work, or has found none."""
        with self._lock:
            if thread not in self._taking:
                return
            self._taking.discard(thread)
            over = self.over
        if over:
            self._done()

    def note_end(self, thread: Thread, source: CallbackSource, *, performed: bool) -> None:
        """Note that `thread` has finished with `source`. `performed` is False if the group was busy."""
        with self._lock:
            self.ended += 1
            if thread not in self._running:
                return
            self._running.discard(thread)
            if not performed:
                self._events[source] = self._events.get(source, 0) + 1
            elif not source.backlog:
                self._events.pop(source, None)
            over = self.over
        if over:
            self._done()

    def _count(self, source: CallbackSource) -> None:
        if source.backlog:
            self._events[source] = source.backlog

    def _take_one(self, source: CallbackSource) -> None:
        left = self._events.pop(source) - 1
        if left:
            self._events[source] = left


_EXIT_GRACE_NS = 1_000_000_000
"""The time in ns for which the interpreter's exit waits for all threads in user code together."""
_IDLE_GRACE = 1.0
"""The time in s that `close` waits for each thread outside user code to end."""


class WorkerPool:
    """Up to `limit` threads. Each of them runs `serve` until that returns.

    They are daemon threads, so a callback that blocks for ever does not keep the interpreter from ending.
    `wake_all` wakes all sleeping threads, so that they see that they have to end.
    """

    __slots__ = (
        '__weakref__',
        '_lock',
        '_serve',
        '_threads',
        '_wake_all',
        'busy',
        'closed',
        'limit',
        'serving',
        'taking',
    )

    def __init__(self, limit: int, serve: Callable[[], None], wake_all: Callable[[], None]) -> None:
        self.limit = limit
        self.closed = False
        self.busy: dict[threading.Thread, CallbackSource] = {}
        """The workers in user code, each with its callback."""
        self.taking: set[threading.Thread] = set()
        """The workers that take work now. A worker leaves this set after it has entered `busy`."""
        self._serve = serve
        self._wake_all = wake_all
        self._lock = threading.Lock()
        self._threads: set[threading.Thread] = set()  # all workers, also those that are about to end
        self.serving: set[threading.Thread] = set()
        """The workers that count against `limit`."""
        _pools.add(self)

    def __len__(self) -> int:
        return len(self.serving)

    def start_worker(self) -> None:
        """Start one more thread, unless there are enough."""
        if len(self) >= self.limit:
            return
        with self._lock:
            if self.closed or len(self) >= self.limit:
                return
            thread = threading.Thread(target=self._run, name='goalwire-callbacks', daemon=True)
            self._threads.add(thread)
            self.serving.add(thread)
            thread.start()

    def retire(self) -> bool:
        """Tell whether there are too many workers, so that the calling worker has to end.

        If so, the worker is not counted from here on. The lock sees to it that of several workers that ask at
        once only the surplus ends.
        """
        with self._lock:
            if len(self) <= self.limit:
                return False
            self.serving.discard(threading.current_thread())
            return True

    def dismiss(self) -> None:
        """Have each thread end as soon as its callback has returned. Idempotent."""
        with self._lock:
            self.closed = True
        self._wake_all()

    def close(self) -> None:
        """End all threads, and wait for those outside user code. Idempotent."""
        self.dismiss()
        for thread in tuple(self._threads):
            if not thread.is_alive():
                continue  # Ctrl-C may have kept it from starting, and join() would raise
            if thread is not threading.current_thread() and thread not in self.busy:
                thread.join(_IDLE_GRACE)

    def reset_in_child(self) -> None:
        """In a forked child, forget the threads: they are the parent's."""
        self._lock = threading.Lock()
        for threads in (self.busy, self.taking, self._threads, self.serving):
            threads.clear()

    def await_end(self, deadline: int | None) -> bool:
        """Wait until all threads but the calling one have ended; False at `deadline` (steady ns)."""
        for thread in tuple(self._threads):
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(None if deadline is None else max(deadline - STEADY.now(), 0) / 1e9)
                if thread.is_alive():
                    return False
        return True

    def _run(self) -> None:
        try:
            self._serve()
        finally:
            with self._lock:
                self.serving.discard(threading.current_thread())
            self.taking.discard(threading.current_thread())
            self._threads.discard(threading.current_thread())


_pools: WeakSet[WorkerPool] = WeakSet()


def _close_all() -> None:
    """End all threads at the interpreter's exit, before the libraries that they use are torn down."""
    pools = tuple(_pools)
    for pool in pools:
        pool.dismiss()
    deadline = STEADY.now() + _EXIT_GRACE_NS
    for pool in pools:
        pool.await_end(deadline)


at_exit(Stage.THREADS, _close_all)


_FEWEST_THREADS = 8
"""The least default limit. Threads are started on demand, and blocked threads cost nothing."""

_PATIENCE = 100_000_000
"""In ns: a spin whose future is settled stops waiting after no callback has ended for this time."""


class MultiThreadedExecutor(Executor):
    """Runs callbacks on workers, which take ready work from one queue. The spinning thread only waits.

    Before a worker runs a callback, it makes sure that another worker sleeps at the queue, and starts one if
    there is none. One sleeper, the watcher, also waits for the next timer and for the file descriptors. While
    no thread spins, the workers sleep at the queue `_handed_over`, into which `spin_once` puts its callback.
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
        self._spins_lock = threading.Lock()
        self._coordinators: list[Waiter] = []
        self._drains: list[DrainTracker] = []
        self._watcher: Waiter | None = None
        self._wanted, self._unwanted = StopWhen(self._is_wanted), StopWhen(self._is_unwanted)

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
        waiter = Waiter()
        self._coordinators.append(waiter)
        with StopConditionScope(self._shutdown_signal, waiter, stop):
            self._open()
            try:
                while True:
                    self._raise_failure()
                    if self._is_shutdown or not self._shutdown_signal.alive:
                        return
                    if stop.completion_state:
                        self._await_drain(waiter, deadline)
                        return
                    if not self._clock.wait(waiter, deadline):
                        return
            finally:
                self._close()
                self._coordinators.remove(waiter)

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
                if not self._clock.wait(waiter, until) and drain.ended == ended:
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

    def _open(self) -> None:
        with self._spins_lock:
            self._spins += 1
        self._send_somebody()

    def _close(self) -> None:
        with self._spins_lock:
            self._spins -= 1
        if not self._spins:
            self._ready.wake_all()  # the workers go on to sleep at `_handed_over`

    def _send_somebody(self) -> None:
        """Have a worker look at the queues: wake one, or start one if none sleeps."""
        if self._handed_over.sleepers:
            self._handed_over.wake_one()
        elif self._ready.sleepers:
            self._ready.wake_one()
        else:
            self._pool.start_worker()

    def _fail(self, error: BaseException) -> None:
        super()._fail(error)
        wake_all(self._coordinators)

    # -- the workers

    def _serve(self) -> None:
        """A worker's loop: run ready work until the worker has to end."""
        waiter, thread, handed_over = self._new_waiter(), threading.current_thread(), self._handed_over
        taking = self._pool.taking
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
                self._sleep_at_queue(waiter)
            else:
                handed_over.park(waiter, self._clock, self._wanted, None)
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

    def _sleep_at_queue(self, waiter: WireWaiter) -> None:
        if self._watcher is None and (self._timer_heap.heap or self._fd_selector.watched):
            self._watcher = waiter
            try:
                # `_watcher` is set before `park` reads the timer heap, so a timer set in between wakes it.
                self._ready.park(waiter, self._clock, self._unwanted, None, self._timer_heap, last=True)
            finally:
                self._watcher = None
        else:
            self._ready.park(waiter, self._clock, self._unwanted, None)
        if not self._spins:
            self._pass_on()

    def _is_unwanted(self) -> bool:
        return not self._spins or bool(self._handed_over.items) or self._retires()

    def _pass_on(self) -> None:
        """Wake the next sleeper if the work is left for which the calling worker was woken."""
        if self._ready.has_work:
            self._ready.wake_one()

    def _look_again(self) -> None:
        watcher = self._watcher
        if watcher is None:
            self._ready.wake_one()
        else:
            watcher.wake()

    def _wake_workers(self) -> None:
        self._pool.close()

    def _wake_all(self) -> None:
        self._ready.wake_all()
        self._handed_over.wake_all()
        wake_all(self._coordinators)
