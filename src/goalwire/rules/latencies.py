"""A histogram of durations: buckets of powers of two, so that adding a duration is one increment."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.rules.statistics import LatencyHistogram

_BUCKETS = 65
"""Differences of two times in 64 bits."""


class Latencies:
    """Durations in ns, below 2**64. Of those that threads add at the very same moment one may be lost."""

    __slots__ = ('counts',)

    def __init__(self) -> None:
        self.counts = [0] * _BUCKETS
        """By the number of bits of the duration. Hot paths count up here themselves, to save a call."""

    def add(self, ns: int) -> None:
        """Note one. Clocks are set back now and then: a negative one counts as 0."""
        self.counts[ns.bit_length() if ns > 0 else 0] += 1

    @property
    def count(self) -> int:
        """How many were added."""
        return sum(self.counts)

    def histogram(self) -> LatencyHistogram:
        """Return the durations so far as a histogram."""
        from goalwire.rules.statistics import LatencyHistogram

        return LatencyHistogram(tuple(self.counts))
