"""Packages by name: their folders and their programs.

ament_index_python answers first, which is the real one if ROS 2 is sourced: installed workspaces, and
packages that pip installed. A package of a workspace's source, found by its package.xml below the working
directory, has its launch files, its configuration and its Python programs where it lies; what C++ makes of it
is there once it is installed. If the working directory is not trusted (goalwire.idl.workspace_roots), nothing
is taken from folders that other users can write to, and what is taken is told.
"""

from __future__ import annotations

import contextlib
import os
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
from goalwire.idl import workspace_roots
from goalwire.idl.search_path import explain_refused, find_package
from goalwire.idl.workspace import MANIFEST, package_name
from goalwire.launching.source_programs import programs_of_group, starters

COMPONENTS = 'rclpy_components'
"""The group of entry points that are components; a name in it is a plugin, as in `my_robot::Camera`."""
_sources: dict[tuple[str, ...], dict[str, str]] = {}


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
        source = use_source(package)
        if source is None:
            raise _missing(package) from error
        return source


def executables(package: str) -> list[str]:
    """The paths of a package's programs, sorted. Raises NoSuchPackageError."""
    folder = Path(prefix(package), 'lib', package)
    if not folder.is_dir():
        return starters(package, source_of(package) or share(package))
    return [str(file) for file in sorted(folder.rglob('*')) if file.is_file() and os.access(file, os.X_OK)]


def executable(package: str, name: str) -> str:
    """The path of one program. Raises NoSuchPackageError, and LaunchError for a program it does not have."""
    found = executables(package)
    source = source_of(package)
    for path in found:
        if os.path.basename(path) == name:
            if source is not None:
                _tell_origin(package, source)
            return path
    known = [os.path.basename(path) for path in found]
    near = get_close_matches(name, known, n=2)
    if near:
        hint = f'did you mean {" or ".join(near)}?'
    elif known:
        hint = f'it has {", ".join(known[:12])}'
    elif source is not None:
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
    """Return the Python components of a package that is found only as source."""
    source = source_of(package)
    found = {} if source is None else programs_of_group(source, COMPONENTS)
    return [EntryPoint(name, f'{module}:{what}', COMPONENTS) for name, (module, what) in found.items()]


def source_packages() -> dict[str, str]:
    """The folders of packages below the working directory, found by package.xml, four levels down at most."""
    root = _working_directory()
    if root is None:
        return {}
    folders = tuple(workspace_roots.walk(root).manifests)
    if folders not in _sources:
        found: dict[str, str] = {}
        for folder in folders:
            with contextlib.suppress(ValueError):
                found.setdefault(package_name(os.path.join(folder, MANIFEST)), folder)
        _sources[folders] = found
    return _sources[folders]


def source_of(package: str) -> str | None:
    """The folder below the working directory that a package is taken from; None if it is installed."""
    folder = source_packages().get(package)
    if folder is None:
        return None
    try:
        get_package_prefix(package)
    except (PackageNotFoundError, ValueError):
        return folder
    # A source package with interfaces counts as installed in a prefix of links; one that pip installed
    # editable from that folder does, too, and is installed.
    found = find_package(package)
    if found is None or found.origin != workspace_roots.WORKING_DIRECTORY:
        return None
    return folder if found.folder == folder else None


def use_source(package: str) -> str | None:
    """The folder of a package below the working directory; its use is told if that is not trusted."""
    folder = source_packages().get(package)
    if folder is not None:
        _tell_origin(package, folder)
    return folder


def _tell_origin(package: str, folder: str) -> None:
    root = _working_directory()
    if root is not None and not root.trusted:
        workspace_roots.tell_origin(package, folder)


def _working_directory() -> workspace_roots.Root | None:
    roots = workspace_roots.find_roots()
    return roots[0] if roots and roots[0].place == workspace_roots.WORKING_DIRECTORY else None


def _missing(package: str) -> NoSuchPackageError:
    near = get_close_matches(package, names(), n=3)
    hint = (
        f'did you mean {" or ".join(near)}?'
        if near
        else 'source the workspace that has it, or install it by pip'
    )
    refused = explain_refused()
    return NoSuchPackageError(f"package '{package}' not found; {hint}{f'; {refused}' if refused else ''}")
