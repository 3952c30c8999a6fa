"""Implementations from PyPI, each installed into an environment of its own, and a world to meet them in."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.environments import CannotInstall, Environment, kept_for_all
from helpers.isolation import isolated_env
from helpers.processes import Program

PROGRAMS = Path(__file__).parent / 'programs'

Install: TypeAlias = Callable[..., Environment]
Run: TypeAlias = Callable[..., Program]


@pytest.fixture(scope='session')
def install(pytestconfig: pytest.Config) -> Install:
    """A function that returns an environment with the packages named, kept between test runs.

    The function skips the test if they cannot be had.
    """

    def install_all(*requirements: str) -> Environment:
        try:
            return kept_for_all(pytestconfig.cache, *requirements)
        except CannotInstall as error:
            pytest.skip(f'{", ".join(requirements)} cannot be installed here: {error}')

    return install_all


@pytest.fixture
def world() -> dict[str, str]:
    """An environment on Zenoh that only this test's programs share."""
    return isolated_env('rmw_zenoh_cpp')


@pytest.fixture
def run(world: dict[str, str]) -> Iterator[Run]:
    """A function that runs a program of `programs/` in the test's world, with any environment's `python`."""
    with ExitStack() as stack:

        def run_one(
            name: str, *arguments: str, python: Path = Path(sys.executable), **variables: str
        ) -> Program:
            program = Program(PROGRAMS / f'{name}.py', *arguments, env=world | variables, python=python)
            return stack.enter_context(program)

        yield run_one
