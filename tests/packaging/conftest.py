"""Real installs: the wheel, and virtual environments to put it into."""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.environments import ROOT, Environment, made_once
from helpers.fresh import output_of


@pytest.fixture
def new_environment(tmp_path: Path) -> Callable[[], Environment]:
    """Make empty virtual environments, each in a folder of its own."""
    numbers = itertools.count()
    return lambda: Environment.create(tmp_path / f'venv{next(numbers)}')


@pytest.fixture(scope='session')
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the committed files that a build needs, and nothing that a build has written."""
    folder = tmp_path_factory.mktemp('checkout')
    for name in ('.gitignore', 'CHANGELOG.md', 'LICENSE', 'README.md', 'hatch_build.py', 'pyproject.toml'):
        shutil.copy(ROOT / name, folder)
    (folder / 'tools').mkdir()
    shutil.copy(ROOT / 'tools' / 'generate.py', folder / 'tools')
    built = shutil.ignore_patterns('*.pyi', 'standard_hashes.py', '__pycache__')
    shutil.copytree(ROOT / 'src', folder / 'src', ignore=built)
    return folder


@pytest.fixture(scope='session')
def wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout."""
    dist = made_once(tmp_path_factory, 'dist', lambda folder: build('wheel', checkout, folder))
    return next(dist.glob('*.whl'))


@pytest.fixture(scope='session')
def editable_wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel that `pip install -e .` makes of this checkout and installs."""
    return build('editable', checkout, tmp_path_factory.mktemp('dist'))


@pytest.fixture(scope='session')
def sdist(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source archive of this checkout."""
    return build('sdist', checkout, tmp_path_factory.mktemp('dist'))


def build(kind: str, source: Path, folder: Path) -> Path:
    """Build as pip does (PEP 517, PEP 660), offline: with the hatchling that the tests have."""
    program = f'import sys, hatchling.build; print(hatchling.build.build_{kind}(sys.argv[1]))'
    return folder / output_of(program, str(folder), cwd=source).splitlines()[-1]
