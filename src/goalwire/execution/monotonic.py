"""The machine's clock. Only here does the execution core read the time and sleep."""

from __future__ import annotations

import time
from typing import Protocol


class Sleeper(Protocol):
    """Where a thread sleeps: a waiter."""

    def wait(self, timeout_ns: int | None = None) -> bool:
        """Sleep until woken (True) or for `timeout_ns` (False)."""


class SteadyClock:
    """The machine's clocks, and waiting on them. A clock of a test's own overrides all three methods.

    hot path: reading them enters no function of Python's, which is 0.6 us less for each tick and each call.
    Read them as `clock.now()` where they are needed: a virtual clock does not reach a `now` that is kept.
    """

    __slots__ = ()

    now = staticmethod(time.monotonic_ns)
    """Steady time in ns, which all deadlines are readings of."""

    system_now = staticmethod(time.time_ns)
    """System time in ns since the UNIX epoch."""

    def wait(self, waiter: Sleeper, deadline_ns: int | None) -> bool:
        """Sleep in `waiter` until it is woken (True) or steady time reaches `deadline_ns` (False)."""
        if deadline_ns is None:
            return waiter.wait(None)
        return waiter.wait(deadline_ns - self.now())


STEADY = SteadyClock()
"""The machine's own time."""

_MACHINE = (SteadyClock.now,)  # in a tuple: virtual time replaces each name that a module has for a clock


def is_machine_time(clock: SteadyClock) -> bool:
    """Whether a clock goes by the machine: not one of a test's own, and no virtual time stands in for it.

    Code that looks at a program from time to time asks first. Virtual time leaps from one deadline to the
    next, and its looks would be deadlines, too.
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

    Raises TypeError for what is not a number, ValueError for nan; both say `what` it was.
    """
    try:
        return int(min(timeout, _FOREVER) * 1e9)
    except (TypeError, ValueError) as error:
        raise type(error)(f'{what} is a number of seconds, not {timeout!r}') from None


_FOREVER = 4e9
"""In s, a century: float('inf') counts as this."""
