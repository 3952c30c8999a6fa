"""Interface packages that installed distributions register under the entry point `goalwire.interfaces`.

In pyproject.toml of such a distribution:

    [project.entry-points."goalwire.interfaces"]
    humanoid_interfaces = "humanoid_definitions"   # the Python package whose folder holds msg/, srv/, action/

importlib.metadata costs 20 ms to import, so the files are looked through for the group's name first.
"""

import os
import sys

GROUP = 'goalwire.interfaces'
_cache: dict[tuple[str, ...], dict[str, str]] = {}


def registrations() -> dict[str, str]:
    """Interface package name -> name of the Python package that holds its definitions."""
    key = tuple(sys.path)
    if key not in _cache:
        found: dict[str, str] = {}
        for folder in key:
            for metadata in _metadata_with_group(folder or '.'):
                for name, value in _entries(metadata):
                    found.setdefault(name, value)
        _cache[key] = found
    return _cache[key]


def folder_of(value: str) -> str | None:
    """The folder of a Python package, which is not imported (its parents are, for a dotted name)."""
    from importlib.util import find_spec

    try:
        spec = find_spec(value)
    except ImportError:
        return None
    if spec is None or not spec.submodule_search_locations:
        return None
    return next(iter(spec.submodule_search_locations), None)


def forget() -> None:
    _cache.clear()


def _metadata_with_group(folder: str) -> list[str]:
    try:
        names = os.listdir(folder)
    except OSError:  # a zip file, or nothing at all
        return []
    found = []
    for name in sorted(names):
        if not name.endswith(('.dist-info', '.egg-info')):
            continue
        metadata = os.path.join(folder, name)
        try:
            with open(os.path.join(metadata, 'entry_points.txt'), 'rb') as content:
                if GROUP.encode() in content.read():
                    found.append(metadata)
        except OSError:
            continue
    return found


def _entries(metadata: str) -> list[tuple[str, str]]:
    from importlib.metadata import PathDistribution
    from pathlib import Path

    entries = PathDistribution(Path(metadata)).entry_points
    return [(entry.name, entry.value) for entry in entries if entry.group == GROUP]
