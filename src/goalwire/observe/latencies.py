"""The durations of calls: percentiles and a histogram."""

from __future__ import annotations

import math
from collections import deque

KEPT = 1000
_STEPS = (1.0, 2.0, 3.0, 5.0, 7.0)
"""The limits of a histogram's bins, as factors of each power of ten."""


class Latencies:
    """The durations of the latest calls, in s."""

    def __init__(self, kept: int = KEPT) -> None:
        self._seconds: deque[float] = deque(maxlen=kept)
        self.number = 0
        """The number of calls that were answered, including calls whose durations were dropped since."""
        self.failed = 0

    def note(self, seconds: float) -> None:
        """Count one answer."""
        self._seconds.append(seconds)
        self.number += 1

    def __len__(self) -> int:
        return len(self._seconds)

    def percentile(self, share: float) -> float:
        """Return the duration in s that the given share of the calls (0 to 1) did not exceed; 0 without
        calls.
        """
        ordered = sorted(self._seconds)
        # 1e-9 is subtracted because of rounding: in floats 0.07 * 100 is a little more than 7.
        return ordered[max(0, math.ceil(share * len(ordered) - 1e-9) - 1)] if ordered else 0.0

    def histogram(self) -> list[tuple[float, int]]:
        """Return upper limits (1, 2, 3, 5, 7, 10 … of each power of ten) and the number of calls between each
        limit and the limit before.

        Empty bins are left out at both ends.
        """
        found: list[tuple[float, int]] = []
        rest, power = sorted(self._seconds), 1e-6
        while rest:
            for step in _STEPS:
                upper = step * power
                below = sum(1 for each in rest if each < upper)
                rest = rest[below:]
                if below or (found and rest):
                    found.append((upper, below))
            power *= 10.0
        return found


def show_seconds(seconds: float) -> str:
    """Return a duration as text for people, in ms or s."""
    return f'{seconds * 1000:.3g} ms' if seconds < 1 else f'{seconds:.3g} s'
