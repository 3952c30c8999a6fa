"""Real installs: the wheel, and virtual environments to put it into."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.environments import ROOT, Environment
from helpers.fresh import output_of


@pytest.fixture
def new_environment(tmp_path: Path) -> Callable[[], Environment]:
    """Make empty virtual environments, each in a folder of its own."""
    numbers = itertools.count()
    return lambda: Environment.create(tmp_path / f'venv{next(numbers)}')


@pytest.fixture(scope='session')
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout."""
    return _build('wheel', tmp_path_factory.mktemp('dist'))


@pytest.fixture(scope='session')
def editable_wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pip install -e .` makes of this checkout and installs."""
    return _build('editable', tmp_path_factory.mktemp('dist'))


def _build(kind: str, folder: Path) -> Path:
    """Build as pip does (PEP 517, PEP 660), offline: with the hatchling that the tests have."""
    program = f'import sys, hatchling.build; print(hatchling.build.build_{kind}(sys.argv[1]))'
    return folder / output_of(program, str(folder), cwd=ROOT).splitlines()[-1]
