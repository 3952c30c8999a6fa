"""Finds free places in a data segment: first fit, and adjacent free places are joined.

The lowest place that fits is taken. So a publisher of messages of one size uses the same pages again and
again, and these are in the processor's cache and in both sides' page tables.
"""

from __future__ import annotations

from bisect import bisect_left

ALIGNMENT = 64


class Allocator:
    """The table of the free places of one segment."""

    def __init__(self, size: int) -> None:
        self._starts = [0]
        self._sizes = [size]

    @property
    def largest(self) -> int:
        """Bytes of the largest free place."""
        return max(self._sizes, default=0)

    def take(self, size: int) -> int | None:
        """Reserve `size` bytes and return their offset; None if no free place is large enough."""
        size = round_up(size)
        for at, free in enumerate(self._sizes):
            if free >= size:
                start = self._starts[at]
                if free == size:
                    del self._starts[at], self._sizes[at]
                else:
                    self._starts[at] = start + size
                    self._sizes[at] = free - size
                return start
        return None

    def give(self, start: int, size: int) -> None:
        """Free the `size` bytes at an offset that `take` has returned."""
        size = round_up(size)
        at = bisect_left(self._starts, start)
        self._starts.insert(at, start)
        self._sizes.insert(at, size)
        if at + 1 < len(self._starts) and start + size == self._starts[at + 1]:
            self._sizes[at] += self._sizes.pop(at + 1)
            del self._starts[at + 1]
        if at and self._starts[at - 1] + self._sizes[at - 1] == start:
            self._sizes[at - 1] += self._sizes.pop(at)
            del self._starts[at]


def round_up(size: int) -> int:
    """Return how many bytes a chunk of `size` occupies."""
    return -(-size // ALIGNMENT) * ALIGNMENT
