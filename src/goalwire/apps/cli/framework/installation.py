"""Finds the goalwire and the rclpy that this Python imports: the first in sys.path counts."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import goalwire
from goalwire.idl import hook

CODE = Path(goalwire.__file__).resolve().parent
"""The folder that this process imports goalwire from."""
_OVERLAY = Path(hook.OVERLAY).resolve()


def find_rclpy() -> Path | None:
    """Return the folder of the rclpy that `import rclpy` takes here; None if it finds none."""
    return _folder_of(find_spec('rclpy'))


def foreign_rclpy() -> Path | None:
    """Return the folder of an rclpy that is not this goalwire's, whether it is imported or hidden."""
    elsewhere = [entry for entry in sys.path if Path(entry).resolve() != _OVERLAY]
    return _folder_of(PathFinder.find_spec('rclpy', elsewhere))


def _folder_of(spec: ModuleSpec | None) -> Path | None:
    if spec is None or spec.loader is None or spec.origin is None:  # a folder without code has no loader
        return None
    return Path(spec.origin).parent


def is_other_overlay(folder: Path) -> bool:
    """Return whether a folder is the overlay of a goalwire that this process does not import."""
    folder = folder.resolve()
    return folder.parts[-2:] == ('goalwire', 'overlay') and folder != _OVERLAY


def is_of_ros(module: str) -> bool:
    """Return whether a module belongs to a package that both ROS 2 and goalwire provide."""
    package = module.partition('.')[0]
    return bool(package) and any((folder / package).is_dir() for folder in (_OVERLAY, CODE / 'idl' / 'share'))


def other_overlays() -> list[Path]:
    """Return the overlays of other goalwire installations, which their goalwire.pth has put into sys.path."""
    return [Path(entry) for entry in sys.path if is_other_overlay(Path(entry))]


def find_installed() -> list[Distribution]:
    """Return the distributions of goalwire in sys.path, each once; Python imports the first."""
    by_place: dict[Path, Distribution] = {}
    for distribution in distributions(name='goalwire'):
        by_place.setdefault(place_of(distribution), distribution)
    return list(by_place.values())


def place_of(distribution: Distribution) -> Path:
    """Return the folder that a distribution is installed in, such as site-packages."""
    return Path(str(distribution.locate_file(''))).resolve()


def is_imported(distribution: Distribution) -> bool:
    """Return whether the goalwire that this process imports is that of a distribution."""
    return any(CODE.is_relative_to(source.resolve()) for source in _sources(distribution))


def _sources(distribution: Distribution) -> Iterator[Path]:
    """Yield the possible folders of a distribution's code: beside its metadata, or an editable checkout."""
    yield place_of(distribution) / 'goalwire'
    try:  # PEP 610
        origin = json.loads(distribution.read_text('direct_url.json') or '{}')
        if origin.get('dir_info', {}).get('editable'):
            yield Path(url2pathname(urlsplit(origin['url']).path))
    except (ValueError, KeyError, AttributeError):
        return
