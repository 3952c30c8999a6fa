from __future__ import annotations

import asyncio
from contextvars import copy_context

import pytest
from helpers.patience import PATIENCE

from goalwire.execution.asyncio.coroutine_runner import Start
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor


def test_a_coroutine_that_never_began_cleans_up_when_its_lane_is_closed(
    single: SingleThreadedExecutor,
) -> None:
    told: list[str] = []

    async def callback() -> None:
        try:
            await asyncio.sleep(3600)
        finally:
            told.append('cleaned up')

    runner = single._make_runner()
    runner.start(Start(callback(), copy_context(), lambda: told.append('ended')))
    runner.close()
    assert told == ['cleaned up', 'ended']
    assert runner.loop.is_closed()


def test_a_coroutine_that_comes_after_the_lanes_are_closed_is_cancelled_where_it_waits(
    single: SingleThreadedExecutor,
) -> None:
    told: list[str] = []

    async def callback() -> None:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            told.append('cancelled')
            raise

    runners = single._open_runners()
    for _ in range(2):
        runners.start(callback(), copy_context(), lambda: told.append('ended'), None)
        runners.close()
    assert told == ['cancelled', 'ended'] * 2


def test_a_loops_callback_that_exits_keeps_no_coroutine_from_going_on(single: SingleThreadedExecutor) -> None:
    told: list[str] = []

    def leave() -> None:
        raise SystemExit

    async def callback() -> None:
        loop = asyncio.get_running_loop()
        loop.call_soon(leave)
        loop.call_soon(told.append, 'the next callback')
        await asyncio.sleep(0)
        told.append('the coroutine')

    task = single.create_task(callback())
    with pytest.raises(SystemExit):
        single.spin_until_future_complete(task, PATIENCE)
    single.spin_until_future_complete(task, PATIENCE)
    assert told == ['the next callback', 'the coroutine']
