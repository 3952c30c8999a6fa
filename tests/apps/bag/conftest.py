"""Recorders and players in an isolated world, on each transport; and `ros2 bag` as a process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.command_line import Begin, CommandLine, executable
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import server_of_programs


@pytest.fixture
def world() -> dict[str, str]:
    """An environment that one test's programs share."""
    return isolated_env('rmw_zenoh_cpp')


@pytest.fixture
def ros2(world: dict[str, str], tmp_path: Path) -> CommandLine:
    """`ros2`, in a folder of the test."""
    return CommandLine(world, tmp_path, server_of_programs())


@pytest.fixture
def begin(world: dict[str, str]) -> Iterator[Begin]:
    """A function that starts a command."""
    with ExitStack() as stack:

        def begin(*arguments: str, program: str = 'ros2', **variables: str) -> Program:
            command = Program(
                executable(program), *arguments, env={**world, **variables}, server=server_of_programs()
            )
            return stack.enter_context(command)

        yield begin
