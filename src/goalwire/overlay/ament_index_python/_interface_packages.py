"""Interface packages that no prefix has: shipped with goalwire, in a workspace, or installed by pip.

They count as resources of the types 'packages' and 'rosidl_interfaces', in a prefix that has share/<package>.
"""

from __future__ import annotations

from pathlib import Path

from ament_index_python import _linked_prefixes
from goalwire.idl import entry_points, search_path, workspace

PACKAGES = 'packages'
INTERFACES = 'rosidl_interfaces'
RESOURCE_TYPES = frozenset({PACKAGES, INTERFACES})


def names() -> list[str]:
    """Return the names of all interface packages, including those in a prefix."""
    return search_path.package_names()


def share(package: str) -> str | None:
    """Return the package's folder with msg/, srv/ and action/; None if there is no such package."""
    found = _find(package)
    if found is not None:
        found.tell_use()
    return found.folder if found else None


def prefix(package: str) -> str | None:
    """Return the package's prefix; None if there is no such interface package."""
    found = _find(package)
    if found is None:
        return None
    place = Path(found.folder)
    if place.parts[-2:] == ('share', package):
        return str(place.parent.parent)
    return _linked_prefixes.around(
        package, found.folder, of_distribution=package in entry_points.registrations()
    )


def content(resource_type: str, package: str) -> str:
    """Return a resource's text: for 'rosidl_interfaces' the definition files, one a line; else ''."""
    found = search_path.find_package(package) if resource_type == INTERFACES else None
    if found is None:
        return ''
    return ''.join(f'{name}{file.suffix}\n' for name, file in found.files().items())


def _find(package: str) -> search_path.InterfacePackage | None:
    return search_path.find_package(package) if workspace.is_package_name(package) else None
