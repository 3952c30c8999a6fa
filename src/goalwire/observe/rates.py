"""Measures how many messages and bytes per second come to a topic."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

WINDOW_S = 3.0
"""A rate is measured over the latest seconds, of this number."""
_LEAST_S = 0.5
"""The shortest time in s over which a rate is computed: over a shorter burst it would be arbitrary."""


class Pace(NamedTuple):
    """A rate: messages and bytes per second."""

    messages: float
    bytes: float


class Rate:
    """How often messages come, computed from the times of arrival and the numbers of messages up to then.

    The rate is known once two messages have come: the time before the first message says nothing about it.
    """

    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, int, int]] = deque()
        self._has_stopped = False

    def note(self, count: int, at: float, size: int = 0) -> None:
        """Note an arrival: `count` messages with `size` bytes have come so far, the latest at the time `at`.

        `at` is a reading of the monotonic clock, in s.
        """
        arrivals = self._arrivals
        if arrivals and count <= arrivals[-1][1]:
            return
        arrivals.append((at, count, size))
        while len(arrivals) > 2 and at - arrivals[1][0] >= WINDOW_S:
            arrivals.popleft()

    def pace(self, now: float) -> Pace | None:
        """Return the rate over the last 3 s, or between the last two messages if they are further apart.

        Returns None until the rate is known, and 0 if messages came earlier but have stopped.
        """
        arrivals = self._arrivals
        if len(arrivals) < 2 or arrivals[-1][0] - arrivals[0][0] < _LEAST_S:
            return Pace(0.0, 0.0) if self._has_stopped and not arrivals else None
        pace = self.latest()
        assert pace is not None
        if now - arrivals[-1][0] <= max(WINDOW_S, 2 / pace.messages):
            return pace
        arrivals.clear()
        self._has_stopped = True
        return Pace(0.0, 0.0)

    def latest(self) -> Pace | None:
        """Return the rate of the latest noted messages, even if they came long ago or within a short time."""
        if len(self._arrivals) < 2:
            return None
        (began, first, before), (ended, last, size) = self._arrivals[0], self._arrivals[-1]
        lasted = ended - began
        return Pace((last - first) / lasted, (size - before) / lasted) if lasted > 0 else None
