"""One world per test, and programs to run in it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.isolation import NETWORK, isolated_env
from helpers.programs import Start, programs_in, server_of_programs
from helpers.wires import require


@pytest.fixture
def network(request: pytest.FixtureRequest) -> str:
    """The wire between the test's programs; a test chooses others by `indirect` parameters."""
    name: str = getattr(request, 'param', NETWORK)
    require(name)
    return name


@pytest.fixture
def world(network: str) -> dict[str, str]:
    """An environment that only this test's programs share."""
    return isolated_env(network)


@pytest.fixture
def start(world: dict[str, str]) -> Iterator[Start]:
    """A function that starts a program of this folder in the test's world."""
    with programs_in(world, server=server_of_programs()) as start:
        yield start
