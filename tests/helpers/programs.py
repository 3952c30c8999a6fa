"""Programs that tests start in one world: those of tests/processes/programs/ where not said otherwise."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import TypeAlias

from helpers.forking import ForkServer
from helpers.isolation import NETWORK, isolated_env
from helpers.processes import Program

_PROGRAMS = Path(__file__).parents[1] / 'processes' / 'programs'

Start: TypeAlias = Callable[..., Program]
"""`start(name, *arguments, **variables)` runs a program, with more environment variables where given."""


_OF_PROGRAMS = (
    'example_interfaces.action', 'example_interfaces.srv', 'goalwire.aio', 'rclpy', 'rclpy.action',
    'rclpy.executors', 'std_msgs.msg', 'std_srvs.srv',
)  # fmt: skip


@cache
def server_of_programs() -> ForkServer:
    """The process that forks commands and programs of rclpy and goalwire, for all tests of this process."""
    server = ForkServer(_OF_PROGRAMS, isolated_env(NETWORK))
    atexit.register(server.close)
    return server


@contextmanager
def programs_in(
    world: Mapping[str, str], folder: Path = _PROGRAMS, server: ForkServer | None = None
) -> Iterator[Start]:
    """Yield a function that starts programs in `world`; whatever still runs at the end is killed.

    A `server` forks them, but not those with variables of their own: these may be for an interpreter's start.
    """
    with ExitStack() as stack:

        def start(name: str, *arguments: object, **variables: str) -> Program:
            program = Program(
                folder / f'{name}.py',
                *map(str, arguments),
                env={**world, **variables},
                server=None if variables else server,
            )
            return stack.enter_context(program)

        yield start
