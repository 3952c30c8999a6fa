"""The command line against real nodes, on both wires."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.command_line import Begin, CommandLine, executable
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

PROGRAMS = Path(__file__).parent / 'programs'
_OF_COMMANDS = ('goalwire.apps.cli.main', 'goalwire.aio', 'goalwire.observe', 'rclpy')


IN_THE_LONG_RUN = pytest.param(DDS, marks=[pytest.mark.long, pytest.mark.slow])


@pytest.fixture(scope='module', params=['rmw_zenoh_cpp', IN_THE_LONG_RUN])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    """An environment that only this module's programs share, on each wire that robots speak.

    Commands know no wire. So most of them are run on DDS in the long run alone, and in each run those that
    between them use all that commands need of a wire: they are marked `on_dds_too`.
    """
    require(request.param)
    return isolated_env(request.param)


@pytest.fixture(scope='module')
def workshop(world: dict[str, str]) -> Iterator[Program]:
    """The nodes of programs/workshop.py, running."""
    with programs_in(world, PROGRAMS) as start:
        program = start('workshop')
        program.expect('^ready$')
        yield program


@pytest.fixture(scope='module')
def sensor(world: dict[str, str]) -> Iterator[Program]:
    """The node of programs/sensor.py, running."""
    with programs_in(world, PROGRAMS) as start:
        program = start('sensor')
        program.expect('^ready$')
        yield program


@pytest.fixture(scope='session')
def commands() -> Iterator[ForkServer]:
    """The process that forks the commands of all tests: it has imported what they import."""
    with ForkServer(_OF_COMMANDS, isolated_env('rmw_zenoh_cpp')) as server:
        yield server


@pytest.fixture
def ros2(world: dict[str, str], workshop: Program, commands: ForkServer) -> CommandLine:
    """`ros2` beside the workshop."""
    return CommandLine(world, server=commands)


@pytest.fixture
def begin(world: dict[str, str], commands: ForkServer) -> Iterator[Begin]:
    """A function that starts a command."""
    with ExitStack() as stack:

        def begin(*arguments: str, program: str = 'ros2', **variables: str) -> Program:
            environment = {**world, **variables}
            command = Program(executable(program), *arguments, env=environment, server=commands)
            return stack.enter_context(command)

        yield begin


@pytest.fixture
def start(world: dict[str, str]) -> Iterator[Start]:
    """A function that starts one more program of this folder."""
    with programs_in(world, PROGRAMS) as start:
        yield start
