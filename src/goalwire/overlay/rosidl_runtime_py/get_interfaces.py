"""rosidl_runtime_py.get_interfaces: finds the interfaces of packages, and the files that define them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from goalwire.idl import modules, search_path, workspace
from goalwire.idl.workspace import KINDS

__all__ = [
    'get_action_interfaces',
    'get_interface_packages',
    'get_interface_path',
    'get_interfaces',
    'get_message_interfaces',
    'get_service_interfaces',
]


def get_interface_packages() -> dict[str, str]:
    """Return the names of the packages with interfaces, each with its prefix."""
    from ament_index_python.resources import get_resources

    return get_resources('rosidl_interfaces')


def get_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Return {'std_msgs': ['msg/Bool', …]} for these packages or all that have interfaces.

    Raises LookupError for an unknown package.
    """
    return _interfaces(package_names, KINDS)


def get_message_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Do as `get_interfaces`, but for messages only."""
    return _interfaces(package_names, ('msg',))


def get_service_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Do as `get_interfaces`, but for services only."""
    return _interfaces(package_names, ('srv',))


def get_action_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Do as `get_interfaces`, but for actions only."""
    return _interfaces(package_names, ('action',))


def get_interface_path(interface_name: str) -> str:
    """Return the file that defines an interface such as 'std_msgs/msg/String'; a name may have a file ending.

    Raises ValueError for a malformed name, LookupError for an unknown package or file.
    """
    package, *rest = interface_name.split('/')
    if not rest or not all(part and part == part.strip() and part != '..' for part in (package, *rest)):
        raise ValueError(
            f"Invalid interface name '{interface_name}': write package/msg/Name, package/srv/Name or …"
        )
    file = Path(_folder(package), *rest)
    files = [file] if file.suffix else [file.with_suffix(f'.{ending}') for ending in (rest[0], 'idl')]
    for candidate in files:
        if candidate.is_file():
            return str(candidate)
    raise LookupError(f"Could not find the interface '{files[0]}'")


def _interfaces(packages: Iterable[str], kinds: Iterable[str]) -> dict[str, list[str]]:
    names = list(packages) or search_path.package_names()
    found = {}
    for package in names:
        if not workspace.is_package_name(package) or modules.folder_of(package) is None:
            _folder(package)  # raises LookupError only for an unknown package
        elif types := [
            f'{kind}/{name}' for kind in sorted(kinds) for name in modules.type_names(package, kind)
        ]:
            found[package] = types
    return found


def _folder(package: str) -> str:
    """Return the folder of the definitions that an import of the package uses, else its share folder."""
    from ament_index_python.packages import get_package_share_directory

    if workspace.is_package_name(package) and (found := search_path.find_imported_package(package, 'msg')):
        return found.folder
    try:
        return get_package_share_directory(package, print_warning=False)
    except (LookupError, ValueError):
        raise LookupError(f"Unknown package '{package}'") from None
