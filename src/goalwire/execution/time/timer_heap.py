"""The due times of timers and asyncio loops, and a thread that calls entries without an executor."""

from __future__ import annotations

import sys
import threading
from heapq import heapify, heappop, heappush
from threading import Lock
from typing import TYPE_CHECKING, Protocol
from weakref import ref

from goalwire.concurrency.threads import begin, join_begun
from goalwire.execution.waiters import Waiter
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable, Sized

    from goalwire.execution.shutdown_signal import ShutdownSignal, ShutdownWatch


class TimerEntry:
    """A function that is called once, at its due time."""

    __slots__ = ('__weakref__', 'call', 'due', 'reference', 'timer_heap')

    def __init__(self, call: Callable[[], None]) -> None:
        self.call = call
        self.reference = ref(self)
        self.due: int | None = None
        self.timer_heap: TimerHeap | None = None


_NOTHING_DUE = (0, 0, None)
_SOMEBODY = (None,)


class TimerHeap:
    """A heap of entries. An entry that was set again leaves its old item in the heap, which is skipped later.

    If an entry becomes the earliest and `sleepers` is not empty, `on_earlier` is called, outside the lock.
    """

    __slots__ = ('_lock', '_on_earlier', '_serial', '_sleepers', '_stale', 'earliest', 'heap')

    def __init__(self, on_earlier: Callable[[], None], sleepers: Sized = _SOMEBODY) -> None:
        self.heap: list[tuple[int, int, TimerEntry]] = []
        self.earliest: int | None = None
        """The earliest due time, perhaps of a discarded entry. It is never later than that of the first item.
        If a signal handler has raised in a method of this heap, `earliest` may be too early, which costs one
        look.
        """
        self._lock = Lock()
        self._serial = 0
        self._stale = 0
        self._on_earlier = on_earlier
        self._sleepers = sleepers

    def set(self, entry: TimerEntry, due: int) -> None:
        """Have `entry` called at `due` (steady ns). An earlier set time, in any heap, no longer counts."""
        before = entry.timer_heap
        if before is not None and before is not self:
            before.discard(entry)
        with self._lock:
            if entry.timer_heap is self and entry.due is not None:
                self._leave_behind(entry)
            earlier = not self.heap or due < self.heap[0][0]
            self._serial += 1
            entry.due, entry.timer_heap = due, self
            if earlier:
                self.earliest = due
            heappush(self.heap, (due, self._serial, entry))
        if earlier and self._sleepers:
            self._on_earlier()

    def discard(self, entry: TimerEntry) -> None:
        """Remove `entry`, unless it has moved to another timer heap meanwhile."""
        with self._lock:
            if entry.timer_heap is self:
                if entry.due is not None:
                    self._leave_behind(entry)
                entry.due = entry.timer_heap = None

    def call_due(self, now: int) -> None:
        """Call every entry that is due at `now`."""
        # The lock covers one step, and not the call of the entry. So an entry may set entries, and other
        # threads may set and discard entries meanwhile. `earliest` is read without the lock, as a quick look.
        while (earliest := self.earliest) is not None and earliest <= now:
            with self._lock:
                heap = self.heap
                due, _, entry = heappop(heap) if heap and heap[0][0] <= now else _NOTHING_DUE
                self.earliest = heap[0][0] if heap else None
                if entry is None:
                    return
                if entry.due != due or entry.timer_heap is not self:
                    self._stale -= 1
                    continue
                entry.due = entry.timer_heap = None
            entry.call()

    def reset_in_child(self) -> None:
        """In a forked child, make a new lock: a thread of the parent may hold the old one."""
        self._lock = Lock()

    def _leave_behind(self, entry: TimerEntry) -> None:
        """Count the item of `entry` as stale. Remove all stale items when they are more than half of the
        heap.
        """
        self._stale += 1
        if self._stale > 64 and self._stale * 2 > len(self.heap):
            self.heap[:] = [item for item in self.heap if item[2] is not entry and self._lives(item)]
            heapify(self.heap)
            self.earliest = self.heap[0][0] if self.heap else None
            self._stale = 0

    def _lives(self, item: tuple[int, int, TimerEntry]) -> bool:
        return item[2].timer_heap is self and item[2].due == item[0]


CLOSING_S = 5.0
"""The time in s that `close` waits for the running call of an entry."""


class ShutdownListener(Protocol):
    """An object whose `end` is called at the shutdown."""

    def end(self) -> None:
        """React to the shutdown. It may be called more than once."""


class TimerThread:
    """A thread that calls entries at their due time (ns of the context's steady clock). It starts with the
    first entry.

    At the shutdown all remaining entries are called at once, and later entries as soon as they are set. So
    their functions look at the shutdown signal, and never run code of users. `set` and `discard` take about
    one µs each, and wake the thread only if the entry is the earliest.
    """

    def __init__(self, shutdown_signal: ShutdownSignal, name: str) -> None:
        self._shutdown_signal = shutdown_signal
        self._name = name
        self._waiter: Waiter | None = None
        """Made with the thread: virtual time needs a waiter of virtual time, and the context may have been
        made before.
        """
        self._timer_heap = TimerHeap(self._on_earlier)
        self._awake_at: int | None = 0
        """The due time until which the thread sleeps; None: without limit, 0: it is awake."""
        self._listeners: WeakMembers[ShutdownListener] = WeakMembers()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._watch: ShutdownWatch | None = None

    def __len__(self) -> int:
        """Return the number of items in the heap, with those of discarded entries."""
        return len(self._timer_heap.heap)

    def set(self, entry: TimerEntry, due: int) -> None:
        """Have `entry` called at `due`, instead of any earlier set time. Callable from any thread."""
        if self._thread is None:
            self._start()
        self._timer_heap.set(entry, due)
        if not self._shutdown_signal.alive:
            self._call_all()

    def soon(self, entry: TimerEntry) -> None:
        """Have `entry` called as soon as the thread is free."""
        self.set(entry, 0)

    def tell_end(self, who: ShutdownListener) -> None:
        """Have `who.end()` called at the shutdown, on this thread; after the shutdown call it at once.

        `who` is held weakly.
        """
        self._listeners.add(who)
        if self._thread is None:
            self._start()
        if not self._shutdown_signal.alive:
            who.end()

    def discard(self, entry: TimerEntry) -> None:
        """Remove `entry`. A call that runs already goes on."""
        self._timer_heap.discard(entry)

    def close(self) -> None:
        """Call the remaining entries and end the thread, after the shutdown. Idempotent."""
        with self._lock:
            thread, waiter = self._thread, self._waiter
        if thread is not None and waiter is not None and thread is not threading.current_thread():
            waiter.wake()
            if not join_begun(thread, CLOSING_S):
                self._call_all()

    def _start(self) -> None:
        with self._lock:
            if self._thread is None and self._shutdown_signal.alive:
                self._waiter = waiter = Waiter()
                self._watch = self._shutdown_signal.watch(waiter.wake)
                self._thread = threading.Thread(
                    target=self._run, args=(waiter,), name=self._name, daemon=True
                )
                begin(self._thread)

    def _on_earlier(self) -> None:
        due, awake_at, waiter = self._timer_heap.earliest, self._awake_at, self._waiter
        if waiter is not None and due is not None and (awake_at is None or due < awake_at):
            waiter.wake()

    def _run(self, waiter: Waiter) -> None:
        timer_heap, shutdown_signal = self._timer_heap, self._shutdown_signal
        try:
            while shutdown_signal.alive:
                # `_awake_at` is None before the look at the heap: an entry that is set after the look wakes
                # this thread.
                self._awake_at = None
                self._awake_at = due = timer_heap.earliest
                shutdown_signal.clock.wait(waiter, due)
                self._awake_at = 0
                self._call(shutdown_signal.clock.now())
        finally:
            if self._watch is not None:
                self._watch.close()
        self._call_all()

    def _call_all(self) -> None:
        self._call(sys.maxsize)
        for listener in self._listeners.alive():
            listener.end()

    def _call(self, now: int) -> None:
        while True:
            try:
                self._timer_heap.call_due(now)
            except Exception as error:  # a bug in goalwire: the other entries must be called all the same
                from goalwire.logging import get_logger  # imported here: rarely needed
                from goalwire.tracebacks import traceback_text

                get_logger('goalwire.execution').error(
                    f'{self._name}: a timer failed\n{traceback_text(error)}'
                )
            else:
                return
