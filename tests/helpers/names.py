"""Names that no other test uses."""

from __future__ import annotations

from itertools import count

_numbers = count(1)


def fresh_package() -> str:
    """Return the name of an interface package that nobody has defined."""
    return f'fresh{next(_numbers)}_msgs'
