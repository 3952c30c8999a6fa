"""The Python packages that goalwire ships, found like installed packages: `share/rclpy/package.xml`.

If a prefix of the search path has the same package, that one is used.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import goalwire

PREFIX = str(Path(goalwire.__file__).parent / 'prefix')


@cache
def names() -> frozenset[str]:
    """Return the names of the packages."""
    return frozenset(entry.name for entry in Path(PREFIX, 'share').iterdir() if entry.is_dir())


def share(package: str) -> str | None:
    """Return a package's share folder, None for a package that is not shipped."""
    return str(Path(PREFIX, 'share', package)) if package in names() else None
