"""Where a data segment is free: first fit, neighbours joined.

The lowest place that fits is taken, so that a publisher of one size uses the same pages again and again:
they are in the processor's cache and in both sides' page tables.
"""

from __future__ import annotations

from bisect import bisect_left

ALIGNMENT = 64


class Allocator:
    """The free places of one segment."""

    def __init__(self, size: int) -> None:
        self._starts = [0]
        self._sizes = [size]

    @property
    def largest(self) -> int:
        """Bytes of the largest free place."""
        return max(self._sizes, default=0)

    def take(self, size: int) -> int | None:
        """Return where `size` bytes are, from now on taken; None if there is no such place."""
        size = rounded(size)
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
        """Return a place that `take` has given for `size` bytes."""
        size = rounded(size)
        at = bisect_left(self._starts, start)
        self._starts.insert(at, start)
        self._sizes.insert(at, size)
        if at + 1 < len(self._starts) and start + size == self._starts[at + 1]:
            self._sizes[at] += self._sizes.pop(at + 1)
            del self._starts[at + 1]
        if at and self._starts[at - 1] + self._sizes[at - 1] == start:
            self._sizes[at - 1] += self._sizes.pop(at)
            del self._starts[at]


def rounded(size: int) -> int:
    """Return the bytes that a chunk of `size` takes."""
    return -(-size // ALIGNMENT) * ALIGNMENT
