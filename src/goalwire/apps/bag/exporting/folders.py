"""The files that a bag is exported to: one for each topic, and how many messages each has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from goalwire.errors import BagError
from goalwire.files import show
from goalwire.records import record


@record
class Written:
    """A file, or a folder of pictures, and how many messages are in it."""

    path: Path
    count: int
    left_out: tuple[str, ...] = ()
    """Why messages were left out: a sentence for each reason."""


def new_folder(path: Path) -> Path:
    """Make a folder. Raises BagError if the path exists, and OSError."""
    try:
        path.mkdir(parents=True)
    except FileExistsError:
        raise _taken(path) from None
    return path


def refuse_existing(path: Path) -> None:
    """Raise BagError if a path exists: for a library that makes the folder itself."""
    if path.exists():
        raise _taken(path)


def _taken(path: Path) -> BagError:
    return BagError(f"'{show(str(path))}' exists already; choose another folder")


def file_stems(topics: Iterable[str]) -> Mapping[str, str]:
    """Return a unique file name for each topic, without the suffix: /arm/joints becomes arm__joints."""
    stems: dict[str, str] = {}
    taken: set[str] = set()
    for topic in topics:
        plain = topic.strip('/').replace('/', '__')
        stem, number = plain, 2
        while stem.lower() in taken:  # Some file systems ignore case.
            stem, number = f'{plain}_{number}', number + 1
        taken.add(stem.lower())
        stems[topic] = stem
    return stems
