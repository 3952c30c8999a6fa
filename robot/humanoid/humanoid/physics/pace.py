"""Simulated time beside real time: how many ticks are due, and how fast the simulation really is."""

from __future__ import annotations

MOST_BEHIND = 0.2  # s of delay that are caught up; more is dropped, as the simulation is too slow
WINDOW = 1.0  # s over which the real-time factor is measured


class Pace:
    """Counts the ticks that are due: one for each `tick` s of a real clock that starts at `now`."""

    def __init__(self, tick: float, now: float) -> None:
        self._tick = tick
        self._began, self._ticks = now, 0  # when counting last began, and the ticks since then
        self._measured_at, self._simulated = now, 0.0
        self.factor = 1.0  # simulated seconds for each real second, over the last whole window

    def due(self, now: float) -> int:
        """Return how many ticks to simulate now, at most MOST_BEHIND seconds of them."""
        whole = int((now - self._began) / self._tick + 1e-9) - self._ticks
        most = round(MOST_BEHIND / self._tick)
        if whole > most:
            whole = most
            self._began, self._ticks = now, 0
        else:
            self._ticks += max(whole, 0)
        self._measure(now, max(whole, 0))
        return max(whole, 0)

    def _measure(self, now: float, ticks: int) -> None:
        self._simulated += ticks * self._tick
        elapsed = now - self._measured_at
        if elapsed >= WINDOW:
            self.factor = self._simulated / elapsed
            self._measured_at, self._simulated = now, 0.0
