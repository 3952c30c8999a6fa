"""A histogram of durations: buckets of powers of two, so that adding a duration is one increment."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.rules.statistics import LatencyHistogram

_BUCKETS = 65
"""Differences of two times in 64 bits."""


class Latencies:
    """Counts of durations in ns, below 2**64.

    If two threads add a duration at the same moment, one of the two may be lost.
    """

    __slots__ = ('counts',)

    def __init__(self) -> None:
        self.counts = [0] * _BUCKETS
        """The counts, by the number of bits of the duration. Hot paths increment them directly, to save a
        call.
        """

    def add(self, ns: int) -> None:
        """Count a duration. A negative duration, from a clock that was set back, counts as 0."""
        self.counts[ns.bit_length() if ns > 0 else 0] += 1

    @property
    def count(self) -> int:
        """The number of counted durations."""
        return sum(self.counts)

    def histogram(self) -> LatencyHistogram:
        """Return the durations counted so far as a histogram."""
        from goalwire.rules.statistics import LatencyHistogram

        return LatencyHistogram(tuple(self.counts))
