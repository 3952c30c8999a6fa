"""Who is to be woken when: the due times of timers and asyncio loops, in steady time."""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from threading import Lock
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sized


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
