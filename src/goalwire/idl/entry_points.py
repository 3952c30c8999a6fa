"""Interface packages that installed distributions register under the entry point `goalwire.interfaces`.

In pyproject.toml of such a distribution:

    [project.entry-points."goalwire.interfaces"]
    humanoid_interfaces = "humanoid_definitions"   # the Python package whose folder holds msg/, srv/, action/

importlib.metadata costs 20 ms to import and fails on broken files, so this module reads the lines itself.
"""

import os
import sys

from goalwire.files import LARGEST_DEFINITION, read_regular

TYPE_CHECKING = False  # importing typing would take 5 ms
if TYPE_CHECKING:
    from collections.abc import Sequence

GROUP = 'goalwire.interfaces'
_cache: dict[tuple[str, ...], dict[str, str]] = {}


def registrations() -> dict[str, str]:
    """Map each interface package's name to the Python package that holds its definitions."""
    key = python_path()
    if key not in _cache:
        found: dict[str, str] = {}
        for folder in key:
            for text in _entry_points(folder or '.'):
                for name, value in _entries(text):
                    found.setdefault(name, value)
        _cache[key] = found
    return _cache[key]


def python_path() -> tuple[str, ...]:
    """Return the entries of sys.path that are texts: Python ignores other objects, which programs may add."""
    entries: list[object] = list(sys.path)
    return tuple(entry for entry in entries if isinstance(entry, str))


def folder_of(value: str, *, regular: bool = False) -> str | None:
    """Return the folder of a Python package, found by Python's own finders without importing it.

    goalwire's own finder is not asked: it would call this function again.

    With `regular`, only a package with __init__.py is found.
    """
    finders = [finder for finder in sys.meta_path if not getattr(finder, 'finds_interfaces', False)]
    path: Sequence[str] | None = None
    name = ''
    for part in value.split('.'):
        name = f'{name}.{part}' if name else part
        try:
            specs = [finder.find_spec(name, path, None) for finder in finders]
            found = [spec for spec in specs if spec is not None]
            spec = next((spec for spec in found if spec.loader is not None), found[0] if found else None)
            if spec is None or not spec.submodule_search_locations or (regular and spec.loader is None):
                return None
            path = list(spec.submodule_search_locations)
        except Exception:  # other packages' finders may raise any exception, and names may be invalid
            return None
    return os.path.abspath(path[0]) if path else None


def discard() -> None:
    """Forget the entry points that were read; the next call reads them again."""
    _cache.clear()


def _entry_points(folder: str) -> list[str]:
    """Return the text of each distribution's entry_points.txt in a folder; unreadable files are skipped."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if entry.name.endswith(('.dist-info', '.egg-info'))]
    except (OSError, ValueError):  # not a folder: a zip file, or a missing path
        return []
    found = []
    for name in sorted(names):
        try:
            data = read_regular(os.path.join(folder, name, 'entry_points.txt'), LARGEST_DEFINITION)
        except OSError:
            continue
        if GROUP.encode() in data:
            found.append(data.decode(errors='replace'))
    return found


def _entries(text: str) -> list[tuple[str, str]]:
    """Return the entries of goalwire's group: lines `name = value` below `[goalwire.interfaces]`."""
    entries = []
    group = ''
    for line in map(str.strip, text.splitlines()):
        name, equals, value = line.partition('=')
        if line.startswith('[') and line.endswith(']'):
            group = line[1:-1].strip()
        elif equals and group == GROUP and line[0] not in '#;':
            entries.append((name.strip(), value.strip()))
    return entries
