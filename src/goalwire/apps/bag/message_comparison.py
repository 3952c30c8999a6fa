"""Compares a live message with a recorded one, field by field."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from math import isclose, isnan
from typing import Any

from goalwire.idl import type_name
from goalwire.records import record

_INDEX = re.compile(r'\[\d+\]')
_STAMP = 'builtin_interfaces/msg/Time'
SHOWN = 20
"""The largest number of differences that are shown for one message."""


@record
class Tolerance:
    """The differences that are allowed between live messages and recorded ones."""

    number: float = 0.0
    """The greatest allowed difference between floating-point fields."""
    feedback: int = 0
    """How many feedback messages a live goal may have more or fewer than the recorded goal."""
    stamps: bool = False
    """Whether fields of the type builtin_interfaces/msg/Time may differ."""
    fields: tuple[str, ...] = ()
    """Patterns of fields that may differ: 'pose.position.*', or just a field's name for all such fields."""

    def ignores(self, path: str) -> bool:
        """Return whether a field, such as 'poses[3].position.x', may differ."""
        plain = _INDEX.sub('', path)
        last = plain.rpartition('.')[2]
        return any(fnmatchcase(plain, pattern) or pattern == last for pattern in self.fields)


@record
class Difference:
    """One field that differs from the recording."""

    where: str
    """The call or goal whose message has the field, in words."""
    field: str
    now: str
    was: str
    tolerance: float = 0.0

    def __str__(self) -> str:
        allowed = f' (tolerance {self.tolerance:g})' if self.tolerance else ''
        return f'{self.where}: {self.field} {self.now}, was {self.was}{allowed}'


def compare(where: str, now: Any, was: Any, tolerance: Tolerance, prefix: str = '') -> list[Difference]:
    """Return the differences between a live message and a recorded one, the first 20."""
    found: list[Difference] = []
    for difference in _differences(where, prefix, now, was, tolerance):
        found.append(difference)
        if len(found) == SHOWN:
            break
    return found


def _differences(where: str, path: str, now: Any, was: Any, tolerance: Tolerance) -> Iterator[Difference]:
    if tolerance.ignores(path):
        return
    if hasattr(was, 'get_fields_and_field_types'):
        if tolerance.stamps and type_name(type(was)) == _STAMP:
            return
        for field in was.get_fields_and_field_types():
            inner = f'{path}.{field}' if path else field
            yield from _differences(where, inner, getattr(now, field), getattr(was, field), tolerance)
    elif isinstance(was, str | bytes | bool | int | float) or not hasattr(was, '__len__'):
        if not _is_equal(now, was, tolerance):
            bound = tolerance.number if isinstance(was, float) else 0.0
            yield Difference(where, path, *_show_both(now, was), bound)
    elif len(now) != len(was):
        yield Difference(where, f'the length of {path}', str(len(now)), str(len(was)))
    else:
        for index, (one, other) in enumerate(zip(_plain(now), _plain(was), strict=True)):
            yield from _differences(where, f'{path}[{index}]', one, other, tolerance)


def _plain(array: Any) -> Any:
    """Return an array's elements as numbers of Python, not of numpy."""
    return array.tolist() if hasattr(array, 'tolist') else array


def _show_both(now: Any, was: Any) -> tuple[str, str]:
    """Return two values as texts, a float32 without the extra digits of its conversion to a double."""
    if isinstance(was, float) and f'{now:.7g}' != f'{was:.7g}':
        return f'{now:.7g}', f'{was:.7g}'
    return repr(now), repr(was)


def _is_equal(now: Any, was: Any, tolerance: Tolerance) -> bool:
    if isinstance(was, float) and not isinstance(was, bool):
        if isnan(was) or isnan(now):
            return isnan(was) and isnan(now)
        return now == was or isclose(now, was, rel_tol=0.0, abs_tol=tolerance.number)
    return bool(now == was)
