"""One world per test, and programs to run in it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.isolation import NETWORK, isolated_env
from helpers.programs import Start, programs_in


@pytest.fixture
def world() -> dict[str, str]:
    """An environment on Zenoh that only this test's programs share."""
    return isolated_env(NETWORK)


@pytest.fixture
def start(world: dict[str, str]) -> Iterator[Start]:
    """A function that starts a program of this folder in the test's world."""
    with programs_in(world) as start:
        yield start
