"""Coroutines around others: a request is answered or given up, and none is left that was never awaited."""

from __future__ import annotations

import asyncio
import gc
import warnings
from collections.abc import Coroutine
from typing import Any

import pytest
from helpers.loops import run

from goalwire.entities.coroutines import Answering, Enclosing
from goalwire.transport.contract import Request


class Asked(Request):
    """A request that notes what becomes of it."""

    def __init__(self) -> None:
        self.became: list[str] = []

    def reply(self, payload: bytes) -> None:
        self.became.append(payload.decode())

    def cancel(self, reason: str = '') -> None:
        self.became.append(reason)


def _answer(response: object, request: Request) -> None:
    request.reply(str(response).encode())


async def _callback() -> str:
    await asyncio.sleep(0)
    return 'answer'


async def _failing() -> str:
    await asyncio.sleep(0)
    raise ValueError('callback')


def _answering(asked: Asked, callback: Coroutine[Any, Any, str] | None = None) -> Answering:
    return Answering(callback or _callback(), asked, _answer)


def test_what_the_callback_returns_is_sent_when_a_task_runs_it() -> None:
    async def scenario() -> Asked:
        asked = Asked()
        await asyncio.get_running_loop().create_task(_answering(asked))
        return asked

    assert run(scenario()).became == ['answer']


def test_what_the_callback_returns_is_sent_when_it_is_awaited() -> None:
    async def scenario() -> Asked:
        asked = Asked()
        await _answering(asked)
        return asked

    assert run(scenario()).became == ['answer']


def test_an_error_gives_the_request_up_and_goes_on() -> None:
    async def scenario(asked: Asked) -> None:
        with pytest.raises(ValueError, match='callback'):
            await _answering(asked, _failing())

    asked = Asked()
    run(scenario(asked))
    assert asked.became == ['its callback failed: ValueError: callback']


def test_an_answer_that_cannot_be_sent_gives_the_request_up() -> None:
    def refuse(_response: object, _request: Request) -> None:
        raise TypeError('no response')

    async def scenario(asked: Asked) -> None:
        with pytest.raises(TypeError, match='no response'):
            await Answering(_callback(), asked, refuse)

    asked = Asked()
    run(scenario(asked))
    assert asked.became == ['its callback failed: TypeError: no response']


@pytest.mark.parametrize('steps', [0, 1])
def test_cancelled_before_or_after_its_first_step_it_gives_the_request_up(steps: int) -> None:
    async def scenario() -> Asked:
        asked = Asked()
        task: asyncio.Task[None] = asyncio.get_running_loop().create_task(_answering(asked))
        for _ in range(steps):
            await asyncio.sleep(0)
        task.cancel()
        await asyncio.wait([task])
        assert task.cancelled()
        return asked

    assert run(scenario()).became == ['its callback was stopped']


@pytest.mark.parametrize('steps', [0, 1])
def test_closing_it_gives_the_request_up(steps: int) -> None:
    asked = Asked()
    answering = _answering(asked)
    for _ in range(steps):
        answering.send(None)
    answering.close()
    assert asked.became == ['its callback was stopped']


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
