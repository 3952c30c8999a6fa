"""Shared by hz, bw and delay: mean values of repeated measurements, printed once a second."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterable, Callable
from math import sqrt
from time import monotonic
from typing import NamedTuple, TypeVar

T = TypeVar('T')

EVERY_S = 1.0
"""Seconds between two lines of figures, as in ROS 2."""


async def report(messages: AsyncIterable[T], note: Callable[[T], bool], show: Callable[[], None]) -> None:
    """Call `note` with each message, and `show` once a second to print the figures.

    `note` returns False if the message does not count, or if there are too few messages for a figure.
    """
    shown = monotonic()
    async for message in messages:
        if note(message) and monotonic() >= shown + EVERY_S:
            shown = monotonic()
            show()


class Spread(NamedTuple):
    """Mean, extremes and standard deviation of some values."""

    mean: float
    least: float
    most: float
    deviation: float
    number: int


class Window:
    """The latest `size` measured values, of which `spread` gives the mean."""

    def __init__(self, size: int) -> None:
        self.values: deque[float] = deque(maxlen=size)

    def spread(self) -> Spread:
        """Return mean, extremes and standard deviation; needs at least one value."""
        n = len(self.values)
        mean = sum(self.values) / n
        deviation = sqrt(sum((each - mean) ** 2 for each in self.values) / n)
        return Spread(mean, min(self.values), max(self.values), deviation, n)


def spread_text(title: str, mean: float, spread: Spread) -> str:
    """Return ROS 2's two lines about times in s."""
    return (
        f'average {title}: {mean:.3f}\n\tmin: {spread.least:.3f}s max: {spread.most:.3f}s '
        f'std dev: {spread.deviation:.5f}s window: {spread.number}'
    )


def bandwidth_text(bytes_a_second: float, sizes: Spread) -> str:
    """Return ROS 2's two lines about bytes, in a unit that suits the rate."""
    power, unit = (0, 'B') if bytes_a_second < 1e3 else (1, 'KB') if bytes_a_second < 1e6 else (2, 'MB')

    def show_size(number: float) -> str:
        return f'{number:.0f} B' if not power else f'{number / 1000**power:.2f} {unit}'

    return (
        f'{show_size(bytes_a_second)}/s from {sizes.number} messages\n'
        f'\tMessage size mean: {show_size(sizes.mean)} min: {show_size(sizes.least)} '
        f'max: {show_size(sizes.most)}'
    )
