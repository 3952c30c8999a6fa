"""Finds packages by name: their folders and their programs.

ament_index_python is asked first (ROS 2's own if ROS 2 is sourced): it finds installed workspaces and
packages that pip installed. Then source packages below the working directory are searched, by package.xml:
their launch files, configuration and Python programs are used in place; their C++ programs exist only after
an install. If the working directory is not trusted (goalwire.idl.workspace_roots), nothing is used from
folders that other users can write to, and a message names each folder that is used.
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
"""The entry-point group of components in Python; an entry's name is a plugin, as `my_robot::Camera`."""
_sources: dict[tuple[str, ...], dict[str, str]] = {}


def names() -> list[str]:
    """Return the names of all packages, sorted."""
    return sorted(get_packages_with_prefixes().keys() | source_packages().keys())


def prefix(package: str) -> str:
    """Return the prefix that a package is installed in. Raises NoSuchPackageError."""
    try:
        return get_package_prefix(package)
    except (PackageNotFoundError, ValueError) as error:
        source = source_packages().get(package)
        if source is None:
            raise _missing(package) from error
        return source


def share(package: str) -> str:
    """Return the folder with a package's launch/, config/ and package.xml. Raises NoSuchPackageError."""
    try:
        return get_package_share_directory(package)
    except (PackageNotFoundError, ValueError) as error:
        source = use_source(package)
        if source is None:
            raise _missing(package) from error
        return source


def executables(package: str) -> list[str]:
    """Return the paths of a package's programs, sorted. Raises NoSuchPackageError."""
    folder = Path(prefix(package), 'lib', package)
    if not folder.is_dir():
        return starters(package, source_of(package) or share(package))
    return [str(file) for file in sorted(folder.rglob('*')) if file.is_file() and os.access(file, os.X_OK)]


def executable(package: str, name: str) -> str:
    """Return a program's path. Raises NoSuchPackageError, and LaunchError for an unknown program."""
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
    """Return whether a package has a component in Python: an entry point of the group `rclpy_components`."""
    points = [*entry_points(group=COMPONENTS), *source_components(package)]
    return any(point.name == plugin for point in points)


def source_components(package: str) -> list[EntryPoint]:
    """Return the Python components of a package that is present only as source, not installed."""
    source = source_of(package)
    found = {} if source is None else programs_of_group(source, COMPONENTS)
    return [EntryPoint(name, f'{module}:{what}', COMPONENTS) for name, (module, what) in found.items()]


def source_packages() -> dict[str, str]:
    """Return the folders of source packages, up to four levels below the working directory, by name."""
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
    """Return the source folder of a package below the working directory; None if the package is installed."""
    folder = source_packages().get(package)
    if folder is None:
        return None
    try:
        get_package_prefix(package)
    except (PackageNotFoundError, ValueError):
        return folder
    # ament_index_python also finds source packages with interfaces, in a prefix made of links. A package that
    # pip installed as editable has such a prefix, too, but counts as installed.
    found = find_package(package)
    if found is None or found.origin != workspace_roots.WORKING_DIRECTORY:
        return None
    return folder if found.folder == folder else None


def use_source(package: str) -> str | None:
    """Return a package's folder below the working directory; report its use if the latter is untrusted."""
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
