"""Time series of numbers."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Sequence
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


_STEP = re.compile(r'([^.\[\]]+)|\[(\d+)\]')
_OF_JOINT = re.compile(r'(position|velocity|effort)\[(.+)\]')
"""A path in a sensor_msgs/msg/JointState: its joint may be an index or a name."""


def number_at(path: str) -> Callable[[Any], float | None]:
    """Return a function that reads the number at a path of a message, or None if there is no number.

    A path is as 'pose.position.x' or 'covariance[7]'. One as 'position[left_knee]' is that of a joint of a
    JointState, wherever its list has the name.
    """
    of_joint = _OF_JOINT.fullmatch(path)
    steps = [name or int(index) for name, index in _STEP.findall(path)]

    def read(message: Any) -> float | None:
        value = message
        try:
            if of_joint is not None and not of_joint[2].isdigit():
                return float(getattr(message, of_joint[1])[list(message.name).index(of_joint[2])])
            for step in steps:
                value = value[step] if isinstance(step, int) else getattr(value, step)
            return float(value)
        except (IndexError, AttributeError, TypeError, ValueError):
            return None

    return read


def name_joint(path: str, message: Any) -> str:
    """Return a path of a JointState with the joint's name in place of its index; other paths as they are.

    A name that is a number, or that two joints have, stays an index.
    """
    found = _OF_JOINT.fullmatch(path)
    names = getattr(message, 'name', None)
    if found is None or not found[2].isdigit() or names is None or isinstance(names, str):
        return path
    index = int(found[2])
    name = names[index] if index < len(names) else ''
    is_clear = name and not name.isdigit() and list(names).count(name) == 1
    return f'{found[1]}[{name}]' if is_clear else path
