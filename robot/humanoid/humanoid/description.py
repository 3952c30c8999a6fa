"""Finds the description of the body: the URDF of the package humanoid_description."""

from __future__ import annotations

from pathlib import Path

PACKAGE = 'humanoid_description'
FILE = Path('urdf', 'humanoid.urdf')


class NoDescription(ModuleNotFoundError):
    """The package humanoid_description is not installed."""


def urdf_path() -> Path:
    """Return the URDF file: from the workspace, from what pip installed, or from ROS 2's package index.

    Raises NoDescription.
    """
    programs = Path(__file__).resolve().parents[1]
    for beside in (programs.parent, programs):
        if (path := beside / PACKAGE / FILE).is_file():
            return path
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        path = Path(get_package_share_directory(PACKAGE)) / FILE
    except PackageNotFoundError:
        path = FILE
    if path.is_file():
        return path
    raise NoDescription(f'the package {PACKAGE} is not found', name=PACKAGE)


def urdf_text() -> str:
    """Return the text of the URDF file. Raises NoDescription."""
    return urdf_path().read_text(encoding='utf-8')
