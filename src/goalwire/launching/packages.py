"""Packages by name: where they are, and which programs they have.

ament_index_python answers first, which is the real one where ROS 2 is sourced: installed workspaces, and
packages that pip installed. A package of a workspace's source, found by its package.xml below the working
directory, has its launch files, its configuration and its Python programs where it lies; what C++ makes of it
is there once it is installed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
    get_packages_with_prefixes,
)

from goalwire.errors import LaunchError, NoSuchPackageError
from goalwire.idl.workspace import FOLDERS, IGNORE_MARKS, IGNORED, LEVELS, MANIFEST, package_name
from goalwire.launching.source_programs import programs_of_group, starters

COMPONENTS = 'rclpy_components'
"""The group of entry points that are components; a name in it is a plugin, as in `my_robot::Camera`."""
_sources: dict[str, dict[str, str]] = {}


def names() -> list[str]:
    """The names of all packages, sorted."""
    return sorted(get_packages_with_prefixes().keys() | source_packages().keys())


def prefix(package: str) -> str:
    """The folder that a package is installed in. Raises NoSuchPackageError."""
    try:
        return get_package_prefix(package)
    except (PackageNotFoundError, ValueError) as error:
        source = source_packages().get(package)
        if source is None:
            raise _missing(package) from error
        return source


def share(package: str) -> str:
    """The folder of a package's own files: launch/, config/, package.xml. Raises NoSuchPackageError."""
    try:
        return get_package_share_directory(package)
    except (PackageNotFoundError, ValueError) as error:
        source = source_packages().get(package)
        if source is None:
            raise _missing(package) from error
        return source


def executables(package: str) -> list[str]:
    """The paths of a package's programs, sorted. Raises NoSuchPackageError."""
    folder = Path(prefix(package), 'lib', package)
    if not folder.is_dir():
        return starters(package, source_packages().get(package) or share(package))
    return [str(file) for file in sorted(folder.rglob('*')) if file.is_file() and os.access(file, os.X_OK)]


def executable(package: str, name: str) -> str:
    """The path of one program. Raises NoSuchPackageError, and LaunchError for a program it does not have."""
    found = executables(package)
    for path in found:
        if os.path.basename(path) == name:
            return path
    known = [os.path.basename(path) for path in found]
    near = get_close_matches(name, known, n=2)
    if near:
        hint = f'did you mean {" or ".join(near)}?'
    elif known:
        hint = f'it has {", ".join(known[:12])}'
    elif package in source_packages() and prefix(package) == source_packages()[package]:
        hint = 'it is found as source alone: build it (colcon build) where that makes its programs'
    else:
        hint = 'it has no programs'
    folder = os.path.join(prefix(package), 'lib', package)
    raise LaunchError(f"executable '{name}' not found on the libexec directory '{folder}'; {hint}")


def has_component(package: str, plugin: str) -> bool:
    """Say whether a package has a component in Python: an entry point of the group `rclpy_components`."""
    points = [*entry_points(group=COMPONENTS), *source_components(package)]
    return any(point.name == plugin for point in points)


def source_components(package: str) -> list[EntryPoint]:
    """Return the components in Python of a package that is there as source."""
    source = source_packages().get(package)
    found = {} if source is None else programs_of_group(source, COMPONENTS)
    return [EntryPoint(name, f'{module}:{what}', COMPONENTS) for name, (module, what) in found.items()]


def source_packages() -> dict[str, str]:
    """The folders of packages below the working directory, found by package.xml, four levels down at most."""
    root = os.getcwd()
    if root not in _sources:
        found: dict[str, str] = {}
        for folder in _package_folders(root):
            try:
                found.setdefault(package_name(os.path.join(folder, MANIFEST)), folder)
            except ValueError:
                continue
        _sources[root] = found
    return _sources[root]


def _package_folders(root: str) -> Iterator[str]:
    for visited, (folder, below, files) in enumerate(os.walk(root)):
        depth = folder[len(root) :].count(os.sep)
        if MANIFEST in files:
            yield folder
        if MANIFEST in files or depth >= LEVELS or visited > FOLDERS or not IGNORE_MARKS.isdisjoint(files):
            below.clear()
        below[:] = sorted(name for name in below if name[0] != '.' and name not in IGNORED)


def _missing(package: str) -> NoSuchPackageError:
    near = get_close_matches(package, names(), n=3)
    hint = (
        f'did you mean {" or ".join(near)}?'
        if near
        else 'source the workspace that has it, or install it by pip'
    )
    return NoSuchPackageError(f"package '{package}' not found; {hint}")
