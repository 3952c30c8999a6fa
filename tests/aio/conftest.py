"""Nodes of the asyncio API in an isolated world, on each transport."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterator
from typing import Any, TypeVar

import pytest
from helpers.loops import Play, run

from goalwire.aio.node import CONTEXTS
from goalwire.testing import VirtualClock

T = TypeVar('T')
ON_MEMORY = pytest.mark.parametrize('transport_name', ['goalwire_memory'])


@pytest.fixture
def play(isolated: dict[str, str]) -> Play:
    """`play(scenario)` runs an `async def scenario()`; no context outlives it."""

    def play_one(scenario: Callable[[], Coroutine[Any, Any, T]]) -> T:
        result = run(scenario())
        assert CONTEXTS.open == 0, 'contexts left open'
        return result

    return play_one


@pytest.fixture
def clock() -> Iterator[VirtualClock]:
    """Virtual time, exact and without waiting; for tests of times. It needs the memory wire."""
    with VirtualClock() as clock:
        yield clock
