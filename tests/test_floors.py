"""Imports point down only. The floors are those of docs/explanation/architecture.md."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.markdown import DOCS, ROOT, rows

SOURCE = ROOT / 'src' / 'goalwire'
FLOORS = {
    folder.strip('`'): int(floor)
    for floor, folder, _ in rows(DOCS / 'explanation' / 'architecture.md', 'floor')
    if floor.isdecimal()
}
REACHING_UP = {'idl/__init__.py': {'cdr'}, 'idl/slot_types.py': {'overlay'}}
OVERLAY = {file.parent.name for file in (SOURCE / 'overlay').glob('*/__init__.py')}  # the others hold stubs


def _imports(file: Path) -> Iterator[str]:
    """Yield the modules that a file imports anywhere in it, those for types alone included."""
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f'{node.module}.{alias.name}' for alias in node.names)


def _folder(module: str) -> str | None:
    """The folder of the house that a module is in; None for what is none of goalwire's."""
    top, *inner = module.split('.')
    if top in OVERLAY:
        return 'overlay'
    return inner[0] if top == 'goalwire' and inner else None


def _own_folder(file: Path) -> str:
    return file.relative_to(SOURCE).parts[0].removesuffix('.py')


@pytest.mark.parametrize('folder', FLOORS)
def test_a_folder_imports_from_lower_floors_alone(folder: str) -> None:
    for file in SOURCE.rglob('*.py'):
        if _own_folder(file) != folder:
            continue
        name = file.relative_to(SOURCE).as_posix()
        for module in _imports(file):
            target = _folder(module)
            if target in {None, folder} or target in REACHING_UP.get(name, ()):
                continue
            assert target in FLOORS, f'{name} imports {module}, which is on no floor of the page'
            assert FLOORS[target] < FLOORS[folder], f'{name} imports {module}, from floor {FLOORS[target]}'


def test_every_folder_has_its_floor_on_the_page() -> None:
    folders = {_own_folder(file) for file in SOURCE.rglob('*.py')} - {'__init__'}
    assert folders == set(FLOORS)


def test_what_reaches_up_still_does() -> None:
    for name, targets in REACHING_UP.items():
        assert targets <= {_folder(module) for module in _imports(SOURCE / name)}, (
            f'{name} needs no exception'
        )


def test_the_robot_imports_nothing_of_goalwire() -> None:
    programs = [*(ROOT / 'robot' / 'humanoid' / 'humanoid').rglob('*.py'), *(ROOT / 'examples').rglob('*.py')]
    assert len(programs) > 20
    for file in programs:
        if file.parent.name in {'asyncio', 'testing'}:
            continue  # the examples of goalwire's own APIs
        assert not [module for module in _imports(file) if module.startswith('goalwire')], file
