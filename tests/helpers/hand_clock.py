"""A clock that shows what a test has set."""

from __future__ import annotations

from threading import Condition

from helpers.patience import PATIENCE

from goalwire.transport.faults.delay_queue import EventWaiter


class HandClock:
    """Time that passes where a test says so, for a delay queue."""

    def __init__(self) -> None:
        self._now = 0
        self._changed = Condition()
        self._sleepers: dict[EventWaiter, int] = {}

    def now(self) -> int:
        """Return the time that the clock shows, in ns."""
        with self._changed:
            return self._now

    def wait(self, waiter: EventWaiter, deadline_ns: int | None) -> bool:
        """Sleep until woken, or until the clock has been set to the deadline."""
        assert deadline_ns is not None
        with self._changed:
            if self._now >= deadline_ns:
                return False
            self._sleepers[waiter] = deadline_ns
        woken = waiter.wait(int(PATIENCE * 1e9))
        with self._changed:
            self._sleepers.pop(waiter, None)
        return woken

    def advance(self, seconds: float) -> None:
        """Let time pass, and wake who is due."""
        with self._changed:
            self._now += round(seconds * 1e9)
            for waiter, deadline in self._sleepers.items():
                if deadline <= self._now:
                    waiter.wake()
