"""An alarm in the time of a clock, be that the machine's time or somebody's who sets it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.execution.clock import ROSClock
from goalwire.execution.timer_heap import TimerEntry

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.clock import Clock, ClockChange
    from goalwire.execution.node_work_queue import NodeWorkQueue


class ClockTimerEntry(TimerEntry):
    """Rings once when `clock` shows the due time: on an executor's thread, or on the one that sets the time.

    `ring` must be short and call no user code. `due` is None while it is off; it is in ns of the clock where
    somebody sets that, and then in no timer heap.
    """

    __slots__ = ('_clock', '_time', '_work_queue')

    def __init__(self, work_queue: NodeWorkQueue, clock: Clock, ring: Callable[[], None]) -> None:
        super().__init__(ring)
        self._work_queue = work_queue
        self._clock = clock
        self._time = 0

    @property
    def time(self) -> int | None:
        """When it rings, in ns of the clock; None while it is off."""
        return None if self.due is None else self._time

    def follow(self) -> None:
        """Hear of the clock's jumps by itself, where nobody passes them on."""
        if isinstance(self._clock, ROSClock):
            self._clock.watch_jumps(self)

    def set(self, time_ns: int) -> None:
        """Ring at `time_ns`, instead of any time set before; at once where a clock that is set is past it."""
        self._time = time_ns
        clock = self._clock
        if not clock.overridden:
            self._work_queue.set_alarm(self, clock.steady_time_of(time_ns))
            return
        self._work_queue.drop_alarm(self)
        if clock.now_ns() >= time_ns:
            self.ring()
        else:
            self.due = time_ns

    def drop(self) -> None:
        """Ring no more."""
        self._work_queue.drop_alarm(self)

    def remaining_ns(self) -> int | None:
        """What is left until it rings; None while it is off."""
        return None if self.due is None else self._time - self._clock.now_ns()

    def clock_jumped(self, _change: ClockChange, _remaining_ns: int | None) -> None:
        """Look at the clock's new time."""
        if self.due is not None:
            self.set(self._time)
