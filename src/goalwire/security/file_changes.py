"""Whether files of a keystore have changed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def look_at(files: Iterable[Path]) -> tuple[tuple[int, int, int], ...]:
    """Return a value that changes as soon as one of the files has been replaced, written to, or deleted."""
    return tuple(map(_look_at, files))


def _look_at(path: Path) -> tuple[int, int, int]:
    try:
        found = path.stat()
    except OSError:  # the file does not exist
        return 0, 0, 0
    return found.st_ino, found.st_mtime_ns, found.st_size
