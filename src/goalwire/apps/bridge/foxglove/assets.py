"""Reads files for clients, such as meshes and descriptions, only from the packages' share folders."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

MOST_BYTES = 100_000_000
_SCHEME = 'package://'


class NoAssetError(ValueError):
    """A file is not given to the client; the text says why."""


def read_asset(uri: str) -> bytes:
    """Return the content of 'package://name/path'. Blocks. Raises NoAssetError."""
    package, _, inside = uri.removeprefix(_SCHEME).partition('/')
    if not uri.startswith(_SCHEME) or not inside:
        raise NoAssetError(f"only addresses of the form '{_SCHEME}name/meshes/arm.stl' are served")
    try:
        share = Path(get_package_share_directory(package)).resolve()
    except (PackageNotFoundError, ValueError):
        raise NoAssetError(f"there is no package '{package[:100]}' here") from None
    try:
        path = (share / inside).resolve()
        if not path.is_relative_to(share):
            raise NoAssetError('files outside of the package are not served')
        if not path.is_file():
            raise NoAssetError(f"the package '{package}' has no such file")
        if path.stat().st_size > MOST_BYTES:
            raise NoAssetError(f'the file is larger than {MOST_BYTES} bytes')
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, NoAssetError):
            raise
        raise NoAssetError('the file cannot be read') from None
