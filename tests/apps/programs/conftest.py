"""Fixtures for the small programs: they run as processes in a world of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.command_line import executable
from helpers.isolation import NETWORK
from helpers.processes import Program
from helpers.programs import server_of_programs

Run: TypeAlias = Callable[..., Program]


@pytest.fixture
def transport_name() -> str:
    """Processes need a network."""
    return NETWORK


@pytest.fixture
def run(isolated: dict[str, str], tmp_path: Path) -> Iterator[Run]:
    """Start the program of a package as `ros2 run` does; every one is killed at the end."""
    with ExitStack() as stack:

        def start(package: str, program: str, *arguments: str) -> Program:
            words = 'run', package, program, *arguments
            started = Program(executable(), *words, env=isolated, cwd=tmp_path, server=server_of_programs())
            return stack.enter_context(started)

        yield start
