"""ament_index_python.resources: reads the files <prefix>/share/ament_index/resource_index/<type>/<name>."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from ament_index_python import _editable_packages, _interface_packages, _linked_prefixes, _python_packages
from ament_index_python.constants import RESOURCE_INDEX_SUBFOLDER
from ament_index_python.search_paths import get_search_paths

__all__ = [
    'InvalidResourceNameError',
    'InvalidResourceTypeNameError',
    'get_resource',
    'get_resource_types',
    'get_resources',
    'has_resource',
]


class InvalidResourceTypeNameError(ValueError):
    """An error for a resource type with a slash or a backslash."""


class InvalidResourceNameError(ValueError):
    """An error for a resource name with a slash or a backslash."""


def get_resource(resource_type: str, resource_name: str) -> tuple[str, str]:
    """Return a resource's text and the prefix that has it.

    Raises LookupError if there is no such resource, OSError if it cannot be read, ValueErrors for bad names.
    """
    _check(resource_type, resource_name)
    for prefix in get_search_paths():
        file = _index(prefix) / resource_type / resource_name
        if file.is_file():
            try:
                return file.read_text(encoding='utf-8'), _whole(resource_type, resource_name, prefix)
            except OSError as error:
                raise OSError(
                    f"Could not open the resource '{resource_name}' of type '{resource_type}':\n{error}"
                ) from error
    if place := _own_prefix(resource_type, resource_name):
        return _interface_packages.content(resource_type, resource_name), place
    raise LookupError(f"Could not find the resource '{resource_name}' of type '{resource_type}'")


def has_resource(resource_type: str, resource_name: str) -> str | Literal[False]:
    """Return the prefix that has a resource, or False. Raises ValueErrors for bad names."""
    _check(resource_type, resource_name)
    prefix = indexed_prefix(resource_type, resource_name)
    if prefix is not None:
        return _whole(resource_type, resource_name, prefix)
    return _own_prefix(resource_type, resource_name) or False


def get_resources(resource_type: str) -> dict[str, str]:
    """Return the names of a type's resources, each with the first prefix that has it."""
    _check_type(resource_type)
    found: dict[str, str] = {}
    for prefix in get_search_paths():
        for entry in _visible(_index(prefix) / resource_type):
            if not entry.is_dir():
                found.setdefault(entry.name, prefix)
    found = {name: _whole(resource_type, name, prefix) for name, prefix in found.items()}
    if resource_type == _interface_packages.PACKAGES:
        for name in _python_packages.names():
            found.setdefault(name, _python_packages.PREFIX)
        for name in _editable_packages.names():
            if name not in found and (place := _editable_packages.prefix(name)):
                found[name] = place
    if resource_type in _interface_packages.RESOURCE_TYPES:
        for name in _interface_packages.names():
            if name not in found and (place := _own_prefix(resource_type, name)):
                found[name] = place
    return found


def get_resource_types() -> set[str]:
    """Return the types of which any prefix has resources."""
    types = set(_interface_packages.RESOURCE_TYPES)
    for prefix in get_search_paths():
        types |= {entry.name for entry in _visible(_index(prefix)) if entry.is_dir()}
    return types


def indexed_prefix(resource_type: str, resource_name: str) -> str | None:
    """Return the first prefix on the disk whose index has a resource; None if there is no such prefix."""
    for prefix in get_search_paths():
        if (_index(prefix) / resource_type / resource_name).is_file():
            return prefix
    return None


def _whole(resource_type: str, name: str, prefix: str) -> str:
    """Return the prefix to report for a resource.

    For a package from pip, this prefix also has its programs.
    """
    if resource_type == _interface_packages.PACKAGES and prefix in _linked_prefixes.of_pip():
        return _linked_prefixes.with_programs(name, prefix)
    return prefix


def _index(prefix: str) -> Path:
    return Path(prefix, RESOURCE_INDEX_SUBFOLDER)


def _own_prefix(resource_type: str, name: str) -> str | None:
    if resource_type not in _interface_packages.RESOURCE_TYPES:
        return None
    if resource_type == _interface_packages.PACKAGES:
        if name in _python_packages.names():
            return _python_packages.PREFIX
        if (place := _editable_packages.prefix(name)) is not None:
            return place
    return _interface_packages.prefix(name)


def _visible(folder: Path) -> list[Path]:
    """Return the entries of a folder that are not hidden, sorted; [] if it is not a folder."""
    if not folder.is_dir():
        return []
    return sorted(entry for entry in folder.iterdir() if not entry.name.startswith('.'))


def _check(resource_type: str, resource_name: str) -> None:
    _check_type(resource_type)
    if not resource_name:
        raise AssertionError('The resource name must not be empty')
    if _has_separator(resource_name):
        raise InvalidResourceNameError(f"Resource name '{resource_name}' is invalid: it has a slash")


def _check_type(resource_type: str) -> None:
    if not resource_type:
        raise AssertionError('The resource type must not be empty')
    if _has_separator(resource_type):
        raise InvalidResourceTypeNameError(f"Resource type '{resource_type}' is invalid: it has a slash")


def _has_separator(name: str) -> bool:
    return '/' in name or '\\' in name
