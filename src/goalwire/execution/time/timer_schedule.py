"""When a timer is due: its period, its phase, and what happens if its clock jumps."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING

from goalwire.execution.time.clock import ClockChange
from goalwire.rules.latencies import Latencies
from goalwire.rules.time import S_TO_NS

if TYPE_CHECKING:
    from goalwire.execution.time.clock import Clock
    from goalwire.rules.statistics import TimerStatistics


class TimerSchedule:
    """The due times of one timer, in ns of its clock.

    If calls were missed, one call makes up for all of them, and the phase is kept, as in rcl. The lock keeps
    `last_call` and `next_call` consistent, since another thread may set an overridden ROS clock during a
    call. No code of users runs under it. If the machine's clock is set back to before the last call, the
    running period still ends after its length in steady time: at `steady_due`.
    """

    __slots__ = ('_clock', '_lateness', '_lock', '_missed', 'last_call', 'next_call', 'period', 'steady_due')

    def __init__(self, clock: Clock, period: int) -> None:
        """Make a schedule with a `period` in ns. The first call is due one period from now."""
        self.period = period
        """The period in ns. A new period takes effect after the next call."""
        self._clock = clock
        self._lock = Lock()
        self._missed = 0
        self._lateness = Latencies()
        self.last_call = clock.now_ns()
        """The time of the last call; before the first call, the time when the timer was made."""
        self.next_call = self.last_call + period
        """The due time of the next call. `now` adapts it if the clock was set back."""
        self.steady_due = clock.source.now() + period
        """`next_call` in steady time, by the clocks as they were when `next_call` was set."""

    def restart(self) -> None:
        """Begin a new period now."""
        with self._lock:
            self.next_call = self._clock.now_ns() + self.period
            self.steady_due = self._clock.source.now() + self.period

    def advance(self) -> tuple[int, int] | None:
        """Note a call, and set the next due time: in phase, and in the future.

        Returns the due time and the actual time of the call; None if no call is due yet.
        """
        with self._lock:
            now, due = self._clock.now_ns(), self.next_call
            if now < due:
                due = self._due_after_set_back(now)
                if now < due:
                    return None
            period = max(self.period, 0)
            following = due + period
            if following <= now:
                self._missed += (now - following) // period + 1 if period else 0
                following = now if period == 0 else now + period - (now - following) % period
            self.last_call, self.next_call = now, following
            self.steady_due = self._clock.source.now() + following - now
        self._lateness.counts[(now - due).bit_length()] += 1
        return due, now

    def now(self) -> int:
        """Return the clock's time. If the clock was set back, adapt the next call to it."""
        now = self._clock.now_ns()
        if now < self.last_call:
            with self._lock:
                self._due_after_set_back(now)
        return now

    def _due_after_set_back(self, now: int) -> int:
        """Return the due time of the next call. If the clock shows less than the last call, adapt it first.

        Otherwise the timer would stand still until the clock shows the old time again. For an overridden ROS
        clock `follow_jump` does this, but no event tells that the machine's clock was set back.
        """
        if now < self.last_call and not self._clock.overridden:
            self.next_call = now + max(self.steady_due - self._clock.source.now(), 0)
            self.last_call = min(self.next_call - self.period, now)
        return self.next_call

    def next_turn(self) -> int:
        """Return the due time of the next call in the future. If the present call is late, periods are
        skipped.
        """
        late = self.now() - self.next_call
        period = max(self.period, 1)
        return self.next_call if late < 0 else self.next_call + (late // period + 1) * period

    def follow_jump(self, change: ClockChange, remaining_ns: int | None) -> None:
        """Adapt to the clock's new time.

        After a switch of the source, the rest of the period still has to pass: `remaining_ns`, or None if no
        period was running. A jump to before the last call starts a new period (rules of rcl/timer.c).
        """
        with self._lock:
            now = self._clock.now_ns()
            if change is not ClockChange.ROS_TIME_NO_CHANGE:
                if now != 0 and remaining_ns is not None:
                    self.next_call = now + max(remaining_ns, 0)
                    self.last_call = self.next_call - self.period
            elif now < self.last_call:
                self.next_call = now + self.period
                self.last_call = now
            self.steady_due = self._clock.source.now() + self.next_call - now

    def statistics(self) -> TimerStatistics:
        """Return the number of calls, and how late they came."""
        from goalwire.rules.statistics import TimerStatistics

        lateness = self._lateness.histogram()
        return TimerStatistics(self.period / S_TO_NS, lateness.count, self._missed, lateness)
