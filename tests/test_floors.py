"""Imports point down and never in a circle. The floors are those of docs/explanation/architecture.md."""

from __future__ import annotations

import ast
import subprocess

import pytest
from helpers.markdown import DOCS, ROOT, rows

from tools.house import (
    SOURCE,
    Module,
    below_goalwire,
    circles,
    floor_of,
    imported,
    modules,
    silenced_privates,
)

FLOORS = {
    folder.strip('`').replace('/', '.'): int(floor)
    for floor, folder, _ in rows(DOCS / 'explanation' / 'architecture.md', 'floor')
    if floor.isdecimal()
}
REACHING_UP = {'idl': {'cdr'}, 'idl.slot_types': {'overlay'}, 'launching.packages': {'overlay'}}


def _imports(module: Module) -> list[str]:
    """List what a module imports anywhere in it, in functions and for types alone included."""
    return list(imported(ast.walk(module.tree)))


def _folder(target: str) -> str | None:
    """The folder of the house that an import leads to; None for what is none of goalwire's."""
    name = below_goalwire(target)
    return floor_of(name) if name else None


@pytest.mark.parametrize('folder', FLOORS)
def test_a_folder_imports_from_lower_floors_alone(folder: str) -> None:
    for module in modules():
        if module.folder != folder:
            continue
        for imports in _imports(module):
            target = _folder(imports)
            if target in {None, folder} or target in REACHING_UP.get(module.name, ()):
                continue
            assert target in FLOORS, f'{module.name} imports {imports}, which is on no floor of the page'
            assert FLOORS[target] < FLOORS[folder], f'{module.name} imports {imports}, floor {FLOORS[target]}'


def test_every_folder_has_its_floor_on_the_page() -> None:
    assert {module.folder for module in modules() if module.name} == set(FLOORS)


def test_what_reaches_up_still_does() -> None:
    found = {module.name: {_folder(imports) for imports in _imports(module)} for module in modules()}
    for name, targets in REACHING_UP.items():
        assert targets <= found[name], f'{name} needs no exception'


def test_no_files_import_each_other_in_a_circle() -> None:
    assert circles(modules()) == []


def test_private_attributes_are_read_by_their_own_class() -> None:
    files = {module.path for module in modules()}
    for folder in ('benchmarks', 'examples', 'robot', 'tools'):
        files.update((ROOT / folder).rglob('*.py'))
    assert [file for file in sorted(files) if silenced_privates(file.read_text(encoding='utf-8'))] == []


def test_a_silenced_private_is_found_among_others() -> None:
    assert silenced_privates('a._b  # noqa: PLC0415, SLF001 - why\n') == 1
    assert silenced_privates('a._b  # noqa: PLC0415 - SLF is silent here\n') == 0


def test_a_circle_over_types_and_over_a_function_is_found() -> None:
    house = [
        _module('a.py', 'if TYPE_CHECKING:\n    from goalwire.b import B\n'),
        _module('b.py', 'from goalwire.c.d import D'),
        _module('c/__init__.py', ''),
        _module('c/d.py', 'def later():\n    import goalwire.a\n'),
        _module('e.py', 'def later():\n    from goalwire.a import A\n'),
    ]
    assert circles(house) == [['a', 'b', 'c.d']]


def test_a_circle_in_the_overlay_is_found() -> None:
    house = [
        _module('overlay/rclpy/node.py', 'from rclpy import timer'),
        _module('overlay/rclpy/timer.py', 'from rclpy.node import Node'),
    ]
    assert circles(house) == [['overlay.rclpy.node', 'overlay.rclpy.timer']]


def _module(path: str, text: str) -> Module:
    return Module(SOURCE / path, text, ast.parse(text))


def test_the_robot_imports_nothing_of_goalwire() -> None:
    programs = [*(ROOT / 'robot' / 'humanoid' / 'humanoid').rglob('*.py'), *(ROOT / 'examples').rglob('*.py')]
    assert len(programs) > 20
    for file in programs:
        if file.parent.name in {'asyncio', 'testing'}:
            continue  # the examples of goalwire's own APIs
        found = imported(ast.walk(ast.parse(file.read_text(encoding='utf-8'))))
        assert not [name for name in found if name.startswith('goalwire')], file


def test_git_tracks_nothing_that_it_ignores() -> None:
    command = ['git', 'ls-files', '--cached', '--ignored', '--exclude-standard']
    assert subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout == ''
