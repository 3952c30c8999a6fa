"""Programs of `async def` functions in an isolated world, on each transport."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

import pytest
from helpers.loops import Play, run

from goalwire.aio.node import CONTEXTS

T = TypeVar('T')


@pytest.fixture
def play(isolated: dict[str, str]) -> Play:
    """`play(scenario)` runs an `async def scenario()`; no context outlives it."""

    def play_one(scenario: Callable[[], Coroutine[Any, Any, T]]) -> T:
        result = run(scenario())
        assert CONTEXTS.open == 0, 'contexts left open'
        return result

    return play_one
