"""The Python packages that goalwire ships. They are found like installed packages: `share/rclpy/package.xml`.

If a prefix of the search path has a package of the same name, that package is used.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import goalwire

PREFIX = str(Path(goalwire.__file__).parent / 'prefix')


@cache
def names() -> frozenset[str]:
    """Return the names of the shipped packages."""
    return frozenset(entry.name for entry in Path(PREFIX, 'share').iterdir() if entry.is_dir())


def share(package: str) -> str | None:
    """Return a shipped package's share folder; None for any other package."""
    return str(Path(PREFIX, 'share', package)) if package in names() else None
