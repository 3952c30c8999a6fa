"""Rates of messages, latencies of calls, and the courses of numbers over time."""

from __future__ import annotations

import csv
import io
import math
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

_WINDOW_S = 3.0
_LEAST_S = 0.5
"""The least time between the messages from which a rate is told: of a burst it would be anything."""


class Rate:
    """How often messages come, from how many had come when the latest of them came.

    It is told when two messages have come, and not before: the time before the first says nothing.
    """

    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, int]] = deque()
        self._has_stopped = False

    def note(self, count: int, at: float) -> None:
        """Note the number of the latest message, and when it came, by the monotonic clock."""
        arrivals = self._arrivals
        if arrivals and count <= arrivals[-1][1]:
            return
        arrivals.append((at, count))
        while len(arrivals) > 2 and at - arrivals[1][0] >= _WINDOW_S:
            arrivals.popleft()

    def told(self, now: float) -> float | None:
        """Return the messages a second of the last 3 s, or between the last two if they are further apart.

        None until it is known; 0 if messages came, and come no more.
        """
        arrivals = self._arrivals
        if len(arrivals) < 2 or arrivals[-1][0] - arrivals[0][0] < _LEAST_S:
            return 0.0 if self._has_stopped and not arrivals else None
        rate = (arrivals[-1][1] - arrivals[0][1]) / (arrivals[-1][0] - arrivals[0][0])
        if now - arrivals[-1][0] <= max(_WINDOW_S, 2 / rate):
            return rate
        arrivals.clear()
        self._has_stopped = True
        return 0.0


class Latencies:
    """How long the latest calls took."""

    def __init__(self, most: int = 1000) -> None:
        self._seconds: deque[float] = deque(maxlen=most)

    def note(self, seconds: float) -> None:
        """Note one call."""
        self._seconds.append(seconds)

    def __len__(self) -> int:
        return len(self._seconds)

    def percentile(self, share: float) -> float:
        """Return what that share of the calls did not exceed, in s: by the nearest rank. 0 for none."""
        ordered = sorted(self._seconds)
        return ordered[max(0, math.ceil(share * len(ordered)) - 1)] if ordered else 0.0

    def histogram(self, bins: int = 16) -> tuple[list[float], list[int]]:
        """Return the edges, in s and evenly spread over the decades, and how many calls lie between."""
        if not self._seconds:
            return [], []
        low, high = max(min(self._seconds), 1e-6), max(self._seconds)
        high = high if high > low else low * 1.1
        edges = np.geomspace(low, high * 1.0001, bins + 1)
        counts, _ = np.histogram(np.clip(np.array(self._seconds), low, None), bins=edges)
        return [float(edge) for edge in edges], [int(count) for count in counts]


class Series:
    """The latest values of one number, in a ring."""

    def __init__(self, name: str, capacity: int = 20_000) -> None:
        self.name = name
        self._times = np.empty(capacity)
        self._values = np.empty(capacity)
        self._written = 0

    def __len__(self) -> int:
        return min(self._written, len(self._times))

    def append(self, time: float, value: float) -> None:
        """Add a value; the oldest goes where the ring is full."""
        at = self._written % len(self._times)
        self._times[at] = time
        self._values[at] = value
        self._written += 1

    def arrays(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return times and values, the oldest first."""
        size = len(self._times)
        if self._written <= size:
            return self._times[: self._written].copy(), self._values[: self._written].copy()
        cut = self._written % size
        return np.roll(self._times, -cut), np.roll(self._values, -cut)

    def points(self, since: float, most: int = 400) -> list[tuple[float, float]]:
        """Return what to draw: the least and the greatest value of each of `most / 2` spans."""
        times, values = self.arrays()
        start = int(np.searchsorted(times, since))
        times, values = times[start:], values[start:]
        if len(times) <= most:
            return [(float(t), float(v)) for t, v in zip(times, values, strict=True)]
        found: list[tuple[float, float]] = []
        for span in np.array_split(np.arange(len(times)), most // 2):
            part = values[span]
            if np.isnan(part).all():
                continue
            ends = sorted({int(span[np.nanargmin(part)]), int(span[np.nanargmax(part)])})
            found += [(float(times[at]), float(values[at])) for at in ends]
        return found


def signed(number: float) -> str:
    """Return a number with its sign and two places; nothing is '-0.00'."""
    return f'{round(number, 2) + 0.0:+.2f}'


def as_csv(series: Sequence[Series], wall_offset: float = 0.0) -> str:
    """Return the series as CSV: a line a value, with the series' name and its time in s since 1970.

    `wall_offset` is what leads there from the series' times.
    """
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(['series', 'time', 'value'])
    for each in series:
        times, values = each.arrays()
        writer.writerows(
            [_cell(each.name), repr(round(float(time) + wall_offset, 6)), repr(float(value))]
            for time, value in zip(times, values, strict=True)
        )
    return out.getvalue()


def _cell(text: str) -> str:
    """Keep a spreadsheet from taking a name for a formula."""
    return f"'{text}" if text[:1] in {'=', '+', '-', '@'} else text


_MOST_ITEMS = 64


def numbers_in(value: Any, path: str = '') -> Iterator[tuple[str, float]]:
    """Yield path and value of each number in a message, items of short arrays included."""
    if isinstance(value, bool | int | float | np.number):
        yield path, float(value)
    elif hasattr(value, 'get_fields_and_field_types'):
        for name in value.get_fields_and_field_types():
            yield from numbers_in(getattr(value, name), f'{path}.{name}' if path else name)
    elif isinstance(value, str | bytes | bytearray):
        return
    elif hasattr(value, '__len__') and hasattr(value, '__getitem__'):
        for at in range(min(len(value), _MOST_ITEMS)):
            yield from numbers_in(value[at], f'{path}[{at}]')
