"""Sizes as people read them."""

from __future__ import annotations

_UNITS = ('B', 'KiB', 'MiB', 'GiB', 'TiB')


def size_text(size: float) -> str:
    """Return bytes in the largest unit that leaves a number above 1."""
    unit = 0
    while size >= 1024 and unit < len(_UNITS) - 1:
        size, unit = size / 1024, unit + 1
    return f'{size:.{1 if unit else 0}f} {_UNITS[unit]}'
