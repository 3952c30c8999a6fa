"""Imports point down and never in a circle, and private attributes stay private.

import-linter knows the floors; it sees packages. Circles are counted among files, by tools/house.py.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from helpers.markdown import DOCS, ROOT, rows

from tools.house import (
    OVERLAY,
    SOURCE,
    Module,
    circles,
    imported,
    modules,
    silenced_privates,
)

FLOORS = {
    folder.strip('`').replace('/', '.'): int(floor)
    for floor, folder, _ in rows(DOCS / 'explanation' / 'architecture.md', 'floor')
    if floor.isdecimal()
}
LINTED = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['tool']['importlinter']


def test_imports_point_down() -> None:
    """As `make lint` looks at them."""
    pytest.importorskip('importlinter', reason='the checkout was not installed with its extra `lint`')
    command = [str(Path(sys.executable).with_name('lint-imports')), '--no-cache']
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_page_and_the_contract_have_the_same_floors() -> None:
    contract = LINTED['contracts'][0]
    page: dict[int, set[str]] = {}
    for folder, floor in FLOORS.items():
        page.setdefault(floor, set()).add(folder)
    assert set(LINTED['root_packages']) > OVERLAY
    modules_of = {'overlay': OVERLAY, 'apps': set()}  # each application has a row of its own
    for (_, folders), layer in zip(sorted(page.items(), reverse=True), contract['layers'], strict=True):
        expected = {name for folder in folders for name in modules_of.get(folder, {f'goalwire.{folder}'})}
        assert set(re.split(r' [|:] ', layer)) == expected


def test_every_folder_has_its_floor_on_the_page() -> None:
    assert {module.folder for module in modules() if module.name} == set(FLOORS)


def test_no_files_import_each_other_in_a_circle() -> None:
    assert circles(modules()) == []


def test_no_class_has_more_than_300_lines() -> None:
    sizes = {
        f'{module.name}.{item.name}': (item.end_lineno or 0) - item.lineno + 1
        for module in modules()
        for item in ast.walk(module.tree)
        if isinstance(item, ast.ClassDef)
    }
    assert len(sizes) > 1000
    assert {name: lines for name, lines in sizes.items() if lines > 300} == {}


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
        if file.parent.name in {'asyncio', 'fleet_missions', 'missions', 'testing'}:
            continue  # the examples of goalwire's own APIs
        found = imported(ast.walk(ast.parse(file.read_text(encoding='utf-8'))))
        assert not [name for name in found if name.startswith('goalwire')], file


def test_git_tracks_nothing_that_it_ignores() -> None:
    command = ['git', 'ls-files', '--cached', '--ignored', '--exclude-standard']
    assert subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout == ''
