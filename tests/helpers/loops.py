"""Running a test's coroutine in an asyncio loop, with a deadline."""

from __future__ import annotations

import asyncio
import importlib.util
from collections.abc import Callable, Coroutine
from importlib import import_module
from typing import Any, Protocol, TypeVar

from helpers.patience import PATIENCE

T = TypeVar('T')


class Play(Protocol):
    """Runs a scenario to its end in a loop, and returns what it returns."""

    def __call__(self, scenario: Callable[[], Coroutine[Any, Any, T]], /) -> T: ...


LOOPS = ['asyncio', *(['uvloop'] if importlib.util.find_spec('uvloop') else [])]
"""The loops that can be had here."""


def run(coroutine: Coroutine[Any, Any, T], loop: str = 'asyncio') -> T:
    """Run a coroutine to its end in a new loop; fail when it takes too long."""
    factory: Callable[[], asyncio.AbstractEventLoop] | None = None
    if loop != 'asyncio':
        factory = import_module(loop).new_event_loop

    async def bounded() -> T:
        async with asyncio.timeout(PATIENCE) as deadline:
            result = await coroutine
        assert not deadline.expired(), 'the scenario took the end of its time for something else'
        return result

    with asyncio.Runner(loop_factory=factory) as runner:
        return runner.run(bounded())


async def turns(number: int = 20) -> None:
    """Let the loop turn: what was handed to it before has run then, and what that handed on.

    It needs no time to pass.
    """
    for _ in range(number):
        await asyncio.sleep(0)


for _name in LOOPS[1:]:
    # libuv makes a pipe with the first loop of a process and keeps it: no test is to be blamed for that.
    import_module(_name).new_event_loop().close()
