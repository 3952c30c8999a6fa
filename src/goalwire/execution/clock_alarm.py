"""An alarm in the time of a clock, be that the machine's time or somebody's who sets it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.execution.agenda import Alarm
from goalwire.execution.clock import ROSClock

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.clock import Clock, ClockChange
    from goalwire.execution.home import Home


class ClockAlarm:
    """Rings once when `clock` shows the due time: on an executor's thread, or on the one that sets the time.

    `ring` must be short and call no user code.
    """

    __slots__ = ('__weakref__', '_alarm', '_clock', '_home', '_ring', 'due')

    def __init__(self, home: Home, clock: Clock, ring: Callable[[], None]) -> None:
        self._home = home
        self._clock = clock
        self._ring = ring
        self._alarm = Alarm(self._go_off)
        self.due: int | None = None
        """In ns of the clock; None while it is off."""

    def follow(self) -> None:
        """Hear of the clock's jumps by itself, where nobody passes them on."""
        if isinstance(self._clock, ROSClock):
            self._clock.watch_jumps(self)

    def set(self, due_ns: int) -> None:
        """Ring at `due_ns`, instead of any time set before; at once where a clock that is set is past it."""
        self.due = due_ns
        clock, home = self._clock, self._home
        if not clock.overridden:
            home.set_alarm(self._alarm, clock.steady_time_of(due_ns))
            return
        home.drop_alarm(self._alarm)
        if clock.now_ns() >= due_ns:
            self._go_off()

    def _go_off(self) -> None:
        self.due = None
        self._ring()

    def drop(self) -> None:
        """Ring no more."""
        self.due = None
        self._home.drop_alarm(self._alarm)

    def remaining_ns(self) -> int | None:
        """What is left until it rings; None while it is off."""
        return None if self.due is None else self.due - self._clock.now_ns()

    def clock_jumped(self, _change: ClockChange, _remaining_ns: int | None) -> None:
        """Look at the clock's new time."""
        if self.due is not None:
            self.set(self.due)
