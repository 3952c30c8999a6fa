"""The shipped worlds and their files. No package is imported here, so that the command line starts fast."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path

from humanoid.text import quote

FOLDER = Path(__file__).parent / 'files'
HOUSE = 'house'
SHIPPED = ', '.join(sorted(path.stem for path in FOLDER.glob('*.yaml')))
NEEDED = ('numpy', 'scipy', 'yaml')
INSTALL = "pip install numpy scipy PyYAML, or the robot with them: pip install './robot/humanoid[world]'"


class BadWorld(ValueError):
    """The world does not exist, its file has an error, or a package is missing; the text says what to do."""


def path_of(world: str) -> Path:
    """Return the path of a world's file; a word without dot or slash is a shipped world. Raises BadWorld."""
    if '/' in world or '\\' in world or '.' in world:
        return Path(world)
    path = FOLDER / f'{world}.yaml'
    if not path.is_file():
        raise BadWorld(
            f'there is no world {quote(world)}; use {SHIPPED}, or the path of a file, as ./{world}.yaml'
        )
    return path


def choose(world: str | None) -> Path | None:
    """Check a world before any program starts, and return its file. Raises BadWorld."""
    if world is None:
        return None
    missing = [package for package in NEEDED if importlib.util.find_spec(package) is None]
    if missing:
        raise BadWorld(f'a world needs {", ".join(missing)}, which is not installed: {INSTALL}')
    from humanoid.world.file import load

    load(world)
    return path_of(world).resolve()


def parameter(path: Path) -> Sequence[str]:
    """Return the ROS arguments that put a program into a world."""
    return ['-p', f'world:={json.dumps(str(path))}']
