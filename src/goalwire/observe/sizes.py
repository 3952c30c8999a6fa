"""Makes texts of sizes in bytes for people."""

from __future__ import annotations

_UNITS = ('B', 'KiB', 'MiB', 'GiB', 'TiB')


def size_text(size: float) -> str:
    """Return a size in bytes as text, in the largest unit that gives a number of at least 1."""
    unit = 0
    while size >= 1024 and unit < len(_UNITS) - 1:
        size, unit = size / 1024, unit + 1
    return f'{size:.{1 if unit else 0}f} {_UNITS[unit]}'
