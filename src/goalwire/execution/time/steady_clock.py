"""The machine's clock. The execution core reads the time and sleeps only through this module."""

from __future__ import annotations

import time
from typing import Protocol


class Sleeper(Protocol):
    """An object in which a thread sleeps: a waiter."""

    def wait(self, timeout_ns: int | None = None) -> bool:
        """Sleep until woken (True) or for `timeout_ns` (False)."""


class SteadyClock:
    """The machine's clocks, and waiting on them. A test's own clock overrides all three methods.

    hot path: `now` and `system_now` are functions of C, which saves 0.6 us for each tick and each call. Call
    `clock.now()` each time, and keep no reference to `now`: virtual time could not replace that.
    """

    __slots__ = ()

    now = staticmethod(time.monotonic_ns)
    """Steady time in ns. All deadlines are times of this clock."""

    system_now = staticmethod(time.time_ns)
    """System time in ns since the UNIX epoch."""

    def wait(self, waiter: Sleeper, deadline_ns: int | None) -> bool:
        """Sleep in `waiter` until it is woken (True) or steady time reaches `deadline_ns` (False)."""
        if deadline_ns is None:
            return waiter.wait(None)
        return waiter.wait(deadline_ns - self.now())


STEADY = SteadyClock()
"""The machine's own time."""

_MACHINE = (SteadyClock.now,)  # in a tuple, since virtual time replaces the clock in every module-level name


def is_machine_time(clock: SteadyClock) -> bool:
    """Tell whether a clock shows the machine's time: no clock of a test, and no virtual time in its place.

    Code that inspects a program from time to time does so only on the machine's time. Virtual time leaps from
    one deadline to the next, and the times of the inspections would be deadlines, too.
    """
    return clock is STEADY and SteadyClock.now in _MACHINE


def deadline_after(clock: SteadyClock, timeout_sec: float | None) -> int | None:
    """Return the deadline in ns for a timeout as rclpy takes it: None and negative values mean no limit.

    Raises as `timeout_ns` does.
    """
    if timeout_sec is None:
        return None
    ns = timeout_ns(timeout_sec)
    return None if timeout_sec < 0 else clock.now() + ns


def timeout_ns(timeout: float, what: str = 'a timeout') -> int:
    """Return the ns of a time in s, a century at most.

    Raises TypeError if it is not a number, ValueError for nan. The errors' texts call the value `what`.
    """
    try:
        return int(min(timeout, _FOREVER) * 1e9)
    except (TypeError, ValueError) as error:
        raise type(error)(f'{what} is a number of seconds, not {timeout!r}') from None


_FOREVER = 4e9
"""A century in s, to which longer times, such as float('inf'), are shortened."""
