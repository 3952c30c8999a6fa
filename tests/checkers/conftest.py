"""The tools of the extra `checkers`, in an environment that pytest's cache keeps."""

from __future__ import annotations

import tomllib
from zlib import crc32

import pytest
from helpers.environments import CannotInstall, Environment
from helpers.markdown import ROOT

PROJECT = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']
PINNED = PROJECT['optional-dependencies']['checkers']


@pytest.fixture(scope='session')
def checkers(pytestconfig: pytest.Config) -> Environment:
    """An environment with all checkers, which sees the packages of the tests."""
    assert pytestconfig.cache is not None
    folder = pytestconfig.cache.mkdir('checkers') / f'{crc32(str(PINNED).encode()):08x}'
    try:
        environment = Environment.kept(folder, *PINNED)
    except CannotInstall as error:
        if not error.unreachable:
            raise
        pytest.skip(f'PyPI cannot be reached: {error}')
    environment.borrow_tests_packages()
    return environment
