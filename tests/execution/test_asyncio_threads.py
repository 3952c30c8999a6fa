"""Coroutines that have something done in a thread."""

from __future__ import annotations

import asyncio
import threading

import pytest
from helpers.loops import run

from goalwire.execution.asyncio.waiting import in_thread


def test_what_a_function_returns_or_raises_arrives() -> None:
    async def scenario() -> None:
        assert await in_thread(threading.get_ident) != threading.get_ident()
        with pytest.raises(ValueError, match='literal'):
            await in_thread(lambda: int('x'))

    run(scenario())


@pytest.mark.parametrize('fails', [False, True])
def test_a_cancellation_waits_until_the_function_has_ended(fails: bool) -> None:
    async def scenario() -> None:
        ended: list[bool] = []
        begun, gate = asyncio.Event(), threading.Event()
        loop = asyncio.get_running_loop()

        def source() -> None:
            loop.call_soon_threadsafe(begun.set)
            assert gate.wait(10)
            ended.append(True)
            if fails:
                raise ValueError('too late')

        task = asyncio.create_task(in_thread(source))
        await begun.wait()
        for _ in range(2):
            task.cancel()
            await asyncio.sleep(0)
        assert not task.done()
        gate.set()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert ended == [True]

    run(scenario())
