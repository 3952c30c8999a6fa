"""Packages that pip installed editable (`pip install -e`); each gets a prefix of its own.

An editable install copies no data files, so no resource index lists the package. pip's direct_url.json (PEP
610) gives the source folder, and the package.xml in this folder gives the package's name. Launch files and
configuration are used in the source folder; the programs are the scripts that pip made.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from ament_index_python import _linked_prefixes
from goalwire.files import LARGEST_DEFINITION, read_regular
from goalwire.idl import entry_points, workspace


def names() -> list[str]:
    """Return the names of the editable packages, sorted."""
    return sorted(_find_installed(entry_points.python_path()))


def share(package: str) -> str | None:
    """Return the source folder of a package, None if pip has not installed it editable."""
    found = _find_installed(entry_points.python_path()).get(package)
    return None if found is None else found[0]


def prefix(package: str) -> str | None:
    """Return the prefix made for a package.

    It has the programs, and the source folder as the share folder.
    """
    found = _find_installed(entry_points.python_path()).get(package)
    if found is None:
        return None
    source, metadata = found
    return _linked_prefixes.around_source(package, source, metadata)


@cache
def _find_installed(path: tuple[str, ...]) -> dict[str, tuple[str, str]]:
    """Return source folder and dist-info folder by package name.

    Of equal names, the first on Python's path counts.
    """
    found: dict[str, tuple[str, str]] = {}
    for folder in path:
        for metadata in _metadata_folders(folder):
            source = _source_of(metadata)
            name = None if source is None else _package_name(source)
            if source is not None and name is not None:
                found.setdefault(name, (str(source), str(metadata)))
    return found


def _metadata_folders(folder: str) -> list[Path]:
    try:
        return sorted(entry for entry in Path(folder or '.').iterdir() if entry.suffix == '.dist-info')
    except (OSError, ValueError):  # the path entry is a zip file, or does not exist
        return []


def _source_of(metadata: Path) -> Path | None:
    """Return the source folder of an editable install; None for every other distribution."""
    try:
        record = json.loads(read_regular(str(metadata / 'direct_url.json'), LARGEST_DEFINITION))
        url = urlsplit(record['url'])
        editable = record['dir_info']['editable'] is True and url.scheme == 'file'
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return None
    return Path(url2pathname(url.path)) if editable else None


def _package_name(source: Path) -> str | None:
    try:
        return workspace.package_name(str(source / workspace.MANIFEST))
    except ValueError:  # the folder's package.xml is missing or invalid
        return None
