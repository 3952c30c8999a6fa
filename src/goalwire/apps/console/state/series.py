"""Time series of numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np


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
        """Add a value; the oldest goes if the ring is full."""
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
        """Return the points to draw: the least and the greatest value of each of `most / 2` spans."""
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


def put_sign(number: float) -> str:
    """Return a number with its sign and two places; never '-0.00'."""
    return f'{round(number, 2) + 0.0:+.2f}'


def as_csv(series: Sequence[Series], wall_offset: float = 0.0) -> str:
    """Return the series as CSV: a line a value, with the series' name and its time in s since 1970.

    `wall_offset` is added to the times of the series to get these times.
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
    """Return a name that spreadsheets do not take for a formula."""
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
