"""Packages that pip installed editable (`pip install -e`), as packages of a prefix of their own.

An editable install copies no data files, so no index names the package. What pip writes into its dist-info
leads to the source folder (direct_url.json, PEP 610), and the package.xml there names the package. Launch
files and configuration are used where they lie, and the programs are the scripts that pip made.
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
    """Return the names of the packages, sorted."""
    return sorted(_find_installed(entry_points.python_path()))


def share(package: str) -> str | None:
    """Return the source folder of a package, None for a package that is not installed so."""
    found = _find_installed(entry_points.python_path()).get(package)
    return None if found is None else found[0]


def prefix(package: str) -> str | None:
    """Return the prefix that is made for a package: with its programs and its source folder as share."""
    found = _find_installed(entry_points.python_path()).get(package)
    if found is None:
        return None
    source, metadata = found
    return _linked_prefixes.around_source(package, source, metadata)


@cache
def _find_installed(path: tuple[str, ...]) -> dict[str, tuple[str, str]]:
    """The source folder and the dist-info of each package, by name; the first on Python's path wins."""
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
    except (OSError, ValueError):  # a zip file, or nothing at all
        return []


def _source_of(metadata: Path) -> Path | None:
    """The folder of an editable install; None for every other distribution."""
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
    except ValueError:  # there is none, or it cannot be used
        return None
