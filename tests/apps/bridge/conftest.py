"""A robot, bridges beside it, and clients: the tests of a module share the robot and a bridge."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.bridge import Bridge, start_bridge
from helpers.isolation import NETWORK, isolated_env
from helpers.processes import Program
from helpers.programs import server_of_programs

PROGRAMS = Path(__file__).with_name('programs')


@pytest.fixture(scope='module')
def world() -> dict[str, str]:
    """The environment of a module's programs."""
    return isolated_env(NETWORK)


@pytest.fixture(scope='module')
def robot(world: dict[str, str]) -> Iterator[Program]:
    """Topics, a service, an action and parameters."""
    with Program(PROGRAMS / 'robot.py', env=world, server=server_of_programs()) as program:
        program.expect('ready')
        yield program


@pytest.fixture
def bridge(world: dict[str, str]) -> Iterator[Callable[..., Bridge]]:
    """`bridge('rosbridge', '--read-only')` starts one at a free port."""
    with ExitStack() as stack:
        yield lambda protocol, *options: start_bridge(stack, world, protocol, *options)


@pytest.fixture(scope='module')
def rosbridge(world: dict[str, str], robot: Program) -> Iterator[str]:
    """The address of a bridge beside the robot."""
    with ExitStack() as stack:
        yield start_bridge(stack, world, 'rosbridge').url
