"""How often messages come to a topic, and how many bytes."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

WINDOW_S = 3.0
"""A rate is that of the latest seconds."""
_LEAST_S = 0.5
"""The least time that a rate is computed over: the rate of a burst would be arbitrary."""


class Pace(NamedTuple):
    """A rate: messages and bytes per second."""

    messages: float
    bytes: float


class Rate:
    """How often messages come, computed from their number at the time of the latest one.

    The rate is known once two messages have come: the time before the first one tells nothing.
    """

    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, int, int]] = deque()
        self._has_stopped = False

    def note(self, count: int, at: float, size: int = 0) -> None:
        """Note the number of the latest message, when it came, and the bytes of all so far.

        `at` is a reading of the monotonic clock, in s.
        """
        arrivals = self._arrivals
        if arrivals and count <= arrivals[-1][1]:
            return
        arrivals.append((at, count, size))
        while len(arrivals) > 2 and at - arrivals[1][0] >= WINDOW_S:
            arrivals.popleft()

    def pace(self, now: float) -> Pace | None:
        """Return the pace of the last 3 s, or between the last two messages if they are further apart.

        None until it is known; 0 if messages came, and come no more.
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
        """Return the rate of the latest messages, however long ago and however close together they came."""
        if len(self._arrivals) < 2:
            return None
        (began, first, before), (ended, last, size) = self._arrivals[0], self._arrivals[-1]
        lasted = ended - began
        return Pace((last - first) / lasted, (size - before) / lasted) if lasted > 0 else None
