"""Coroutines around others: none of those is left behind without having been awaited."""

from __future__ import annotations

import asyncio
import gc
import warnings
from collections.abc import Coroutine
from typing import Any

import pytest

from goalwire.entities.enclosing import Enclosing


async def inner(told: list[str]) -> str:
    told.append('began')
    await asyncio.sleep(0)
    return 'done'


def enclosing(told: list[str]) -> Enclosing:
    waited_for: Coroutine[Any, Any, str] = inner(told)

    async def outer() -> None:
        told.append(await waited_for)

    return Enclosing(outer(), [waited_for])


def test_it_runs_as_the_coroutine_that_it_is_made_of() -> None:
    told: list[str] = []

    async def run() -> None:
        await enclosing(told)
        await asyncio.create_task(enclosing(told))

    asyncio.run(run())
    assert told == ['began', 'done'] * 2


def test_closed_before_its_first_step_it_leaves_nothing_that_python_warns_of() -> None:
    told: list[str] = []
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter('always')
        enclosing(told).close()
        gc.collect()
    assert not warned
    assert told == []


def test_a_task_that_is_cancelled_before_its_first_step_leaves_nothing_either() -> None:
    told: list[str] = []

    async def run() -> None:
        task: asyncio.Task[None] = asyncio.create_task(enclosing(told))
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter('always')
        asyncio.run(run())
        gc.collect()
    assert not warned
    assert told == []


def test_closed_in_the_middle_it_ends_those_that_it_awaits() -> None:
    told: list[str] = []
    coroutine = enclosing(told)
    coroutine.send(None)
    coroutine.close()
    assert told == ['began']
    with pytest.raises(RuntimeError, match='cannot reuse already awaited coroutine'):
        coroutine.send(None)
