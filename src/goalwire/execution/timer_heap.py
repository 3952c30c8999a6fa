"""Who is called when: the due times of timers and asyncio loops, and a thread for what nobody spins."""

from __future__ import annotations

import sys
import threading
from heapq import heapify, heappop, heappush
from threading import Lock
from typing import TYPE_CHECKING, Protocol

from goalwire.execution.waiting import Waiter, WeakListeners

if TYPE_CHECKING:
    from collections.abc import Callable, Sized

    from goalwire.execution.waiting import ShutdownSignal, ShutdownWatch


class TimerEntry:
    """Something that rings once at its due time."""

    __slots__ = ('__weakref__', 'due', 'ring', 'timer_heap')

    def __init__(self, ring: Callable[[], None]) -> None:
        self.ring = ring
        self.due: int | None = None
        self.timer_heap: TimerHeap | None = None


_NOTHING_DUE = (0, 0, None)
_SOMEBODY = (None,)


class TimerHeap:
    """A heap of alarms. An alarm that was set again leaves its old entry behind, which is skipped.

    `on_earlier` is called, outside the lock, when the earliest due time has moved forward while there are
    `sleepers`, whom that concerns.
    """

    __slots__ = ('_lock', '_on_earlier', '_serial', '_sleepers', '_stale', 'earliest', 'heap')

    def __init__(self, on_earlier: Callable[[], None], sleepers: Sized = _SOMEBODY) -> None:
        self.heap: list[tuple[int, int, TimerEntry]] = []
        self.earliest: int | None = None
        """The earliest due time, perhaps of an alarm that is off by now. Never later than the heap's first;
        too early where a signal's handler has raised in here, until it is rung for."""
        self._lock = Lock()
        self._serial = 0
        self._stale = 0
        self._on_earlier = on_earlier
        self._sleepers = sleepers

    def set(self, alarm: TimerEntry, due: int) -> None:
        """Let `alarm` ring at `due` (steady ns), instead of any time set before, here or elsewhere."""
        before = alarm.timer_heap
        if before is not None and before is not self:
            before.forget(alarm)
        with self._lock:
            if alarm.timer_heap is self and alarm.due is not None:
                self._leave_behind(alarm)
            earlier = not self.heap or due < self.heap[0][0]
            self._serial += 1
            alarm.due, alarm.timer_heap = due, self
            if earlier:
                self.earliest = due
            heappush(self.heap, (due, self._serial, alarm))
        if earlier and self._sleepers:
            self._on_earlier()

    def forget(self, alarm: TimerEntry) -> None:
        """Let `alarm` ring no more, unless it has moved to another timer heap meanwhile."""
        with self._lock:
            if alarm.timer_heap is self:
                if alarm.due is not None:
                    self._leave_behind(alarm)
                alarm.due = alarm.timer_heap = None

    def ring_due(self, now: int) -> None:
        """Ring everything that is due at `now`."""
        while (earliest := self.earliest) is not None and earliest <= now:
            with self._lock:
                heap = self.heap
                due, _, alarm = heappop(heap) if heap and heap[0][0] <= now else _NOTHING_DUE
                self.earliest = heap[0][0] if heap else None
                if alarm is None:
                    return
                if alarm.due != due or alarm.timer_heap is not self:
                    self._stale -= 1
                    continue
                alarm.due = alarm.timer_heap = None
            alarm.ring()

    def _leave_behind(self, alarm: TimerEntry) -> None:
        """Count the entry that `alarm` has here as dead; clear the dead away when they are the majority."""
        self._stale += 1
        if self._stale > 64 and self._stale * 2 > len(self.heap):
            self.heap[:] = [entry for entry in self.heap if entry[2] is not alarm and self._lives(entry)]
            heapify(self.heap)
            self.earliest = self.heap[0][0] if self.heap else None
            self._stale = 0

    def _lives(self, entry: tuple[int, int, TimerEntry]) -> bool:
        return entry[2].timer_heap is self and entry[2].due == entry[0]


CLOSING_S = 5.0
"""How long closing waits for the alarm that rings."""


class ShutdownListener(Protocol):
    """What ends with the shutdown."""

    def end(self) -> None:
        """The shutdown has begun. May come more than once."""


class TimerThread:
    """Rings alarms at their due time (ns of the context's steady clock); the first one starts its thread.

    At the shutdown all that are left ring at once, and later ones as soon as they are set: who
    rings looks at the shutdown signal, and never runs code of users. Setting and dropping cost about one µs
    each and wake nobody, unless the alarm is due before all others.
    """

    def __init__(self, shutdown_signal: ShutdownSignal, name: str) -> None:
        self._shutdown_signal = shutdown_signal
        self._name = name
        self._waiter = Waiter()
        self._timer_heap = TimerHeap(self._on_earlier)
        self._awake_at: int | None = 0
        """When the thread looks at the timer heap anyway; None: never."""
        self._listeners: WeakListeners[ShutdownListener] = WeakListeners()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._watch: ShutdownWatch | None = None

    def __len__(self) -> int:
        """How many alarms are kept, some of which may have been dropped."""
        return len(self._timer_heap.heap)

    def set(self, alarm: TimerEntry, due: int) -> None:
        """Let `alarm` ring at `due`, instead of any time set before. Any thread."""
        if self._thread is None:
            self._start()
        self._timer_heap.set(alarm, due)
        if not self._shutdown_signal.alive:
            self._ring_all()

    def soon(self, alarm: TimerEntry) -> None:
        """Let `alarm` ring as soon as the thread gets to it."""
        self.set(alarm, 0)

    def tell_end(self, who: ShutdownListener) -> None:
        """Call `who.end()` at the shutdown, on the thread; at once after it. Held weakly."""
        self._listeners.add(who)
        if self._thread is None:
            self._start()
        if not self._shutdown_signal.alive:
            who.end()

    def drop(self, alarm: TimerEntry) -> None:
        """Let `alarm` ring no more; it may be ringing."""
        self._timer_heap.forget(alarm)

    def close(self) -> None:
        """Ring what is left and end the thread, after the shutdown. Idempotent."""
        with self._lock:
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            self._waiter.wake()
            thread.join(CLOSING_S)

    def _start(self) -> None:
        with self._lock:
            if self._thread is None and self._shutdown_signal.alive:
                self._watch = self._shutdown_signal.watch(self._waiter.wake)
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()

    def _on_earlier(self) -> None:
        due, awake_at = self._timer_heap.earliest, self._awake_at
        if due is not None and (awake_at is None or due < awake_at):
            self._waiter.wake()

    def _run(self) -> None:
        timer_heap, shutdown_signal = self._timer_heap, self._shutdown_signal
        try:
            while shutdown_signal.alive:
                self._awake_at = None  # before the look: who sets an earlier alarm after it wakes this thread
                self._awake_at = due = timer_heap.earliest
                shutdown_signal.clock.wait(self._waiter, due)
                self._awake_at = 0
                self._ring(shutdown_signal.clock.now())
        finally:
            if self._watch is not None:
                self._watch.close()
        self._ring_all()

    def _ring_all(self) -> None:
        self._ring(sys.maxsize)
        for listener in self._listeners.alive():
            listener.end()

    def _ring(self, now: int) -> None:
        while True:
            try:
                self._timer_heap.ring_due(now)
            except Exception as error:  # a mistake of ours: the other alarms must ring all the same
                from goalwire.logging import get_logger  # needed only then
                from goalwire.logging.tracebacks import traceback_text

                get_logger('goalwire.execution').error(
                    f'{self._name}: an alarm failed\n{traceback_text(error)}'
                )
            else:
                return
