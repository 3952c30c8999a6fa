"""Programs that tests start in one world: those of tests/processes/programs/ where not said otherwise."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TypeAlias

from helpers.processes import Program

_PROGRAMS = Path(__file__).parents[1] / 'processes' / 'programs'

Start: TypeAlias = Callable[..., Program]
"""`start(name, *arguments, **variables)` runs a program, with more environment variables where given."""


@contextmanager
def programs_in(world: Mapping[str, str], folder: Path = _PROGRAMS) -> Iterator[Start]:
    """Yield a function that starts programs in `world`; whatever still runs at the end is killed."""
    with ExitStack() as stack:

        def start(name: str, *arguments: object, **variables: str) -> Program:
            program = Program(folder / f'{name}.py', *map(str, arguments), env={**world, **variables})
            return stack.enter_context(program)

        yield start
