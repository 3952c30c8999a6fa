"""The work that a spin of MultiThreadedExecutor still waits for once its future is settled."""

from __future__ import annotations

from _thread import allocate_lock
from typing import TYPE_CHECKING

from goalwire.concurrency.snapshots import copy_of
from goalwire.execution.event_queue import EventQueue

if TYPE_CHECKING:
    from collections.abc import Callable
    from threading import Thread

    from goalwire.execution.executors.worker_pool import WorkerPool
    from goalwire.execution.ready_queue import CallbackSource, ReadyQueue


class DrainTracker:
    """The work that is ready when a spin's future is settled, and that the spin still waits for.

    Each worker reports the begin and the end of its callbacks. `done` is called after the last callback.
    Tasks and timers whose callbacks run already are not waited for, since such a callback may run for long.

    Work goes from the ready queue to a worker in three steps: the worker enters `taking`, takes the work, and
    enters itself with the work in `busy`. `gather` looks in the same order, so it misses no work.
    """

    def __init__(self, done: Callable[[], None]) -> None:
        self.changes = 0
        """How often a callback has begun or ended since the tracker was made."""
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
            self.changes += 1
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
            self.changes += 1
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
