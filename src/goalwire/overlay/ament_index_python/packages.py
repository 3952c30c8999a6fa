"""ament_index_python.packages: finds the prefixes and share folders of packages."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

from ament_index_python import _editable_packages, _interface_packages, _python_packages
from ament_index_python.constants import AMENT_PREFIX_PATH_ENV_VAR
from ament_index_python.resources import get_resource, get_resources, indexed_prefix
from ament_index_python.search_paths import get_search_paths

__all__ = [
    'PackageNotFoundError',
    'get_package_prefix',
    'get_package_share_directory',
    'get_package_share_path',
    'get_packages_with_prefixes',
]


class PackageNotFoundError(KeyError):
    """An error if no prefix has a package, and no interface package has its name."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ''  # KeyError's own __str__ would add quotes


def get_packages_with_prefixes() -> dict[str, str]:
    """Return all packages by name, each with the prefix that has it."""
    return get_resources('packages')


def get_package_prefix(package_name: str) -> str:
    """Return the prefix that a package is installed in.

    Raises PackageNotFoundError (a KeyError), and ValueError for an invalid package name (REP 144).
    """
    _check_name(package_name)
    try:
        return get_resource('packages', package_name)[1]
    except LookupError:
        raise _not_found(package_name) from None


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:
    """Return a package's share folder; warn if the folder does not exist.

    Raises as get_package_prefix does.
    """
    return _share(package_name, print_warning)


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:
    """Return the result of get_package_share_directory as a Path."""
    return Path(_share(package_name, print_warning))


def _share(package: str, print_warning: bool) -> str:
    _check_name(package)
    prefix = indexed_prefix('packages', package)
    if prefix is None:
        share = (
            _python_packages.share(package)
            or _editable_packages.share(package)
            or _interface_packages.share(package)
        )
        if share is None:
            raise _not_found(package)
        return share
    folder = Path(prefix, 'share', package)
    if print_warning and not folder.exists():
        warnings.warn(f'Share directory for {package} ({folder}) does not exist.', stacklevel=3)
    return str(folder)


def _check_name(package: str) -> None:
    if re.fullmatch('[a-zA-Z0-9][a-zA-Z0-9_-]+', package, re.ASCII) is None:
        raise ValueError(f"'{package}' is not a valid package name")


def _not_found(package: str) -> PackageNotFoundError:
    return PackageNotFoundError(
        f"package '{package}' not found, searching: {get_search_paths()} "
        f'(source the workspace that has it, or name its prefix in {AMENT_PREFIX_PATH_ENV_VAR})'
    )
