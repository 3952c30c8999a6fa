"""A queue from threads to coroutines."""

from __future__ import annotations

import asyncio
import threading

import pytest
from helpers.loops import LOOPS, run

from goalwire.execution.asyncio.waiting import AsyncQueue


@pytest.mark.parametrize('loop', LOOPS)
def test_what_another_thread_delivers_comes_in_order(loop: str) -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue()

        def deliver() -> None:
            for number in range(1000):
                stream.deliver(number)
            stream.close()

        thread = threading.Thread(target=deliver)
        thread.start()
        assert [number async for number in stream] == list(range(1000))
        thread.join()

    run(scenario(), loop)


def test_the_oldest_is_dropped_and_counted_where_it_is_full() -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue(2)
        for number in range(5):
            stream.deliver(number)
        assert (len(stream), stream.dropped) == (2, 3)
        stream.close()
        assert [number async for number in stream] == [3, 4]

    run(scenario())


def test_closing_ends_all_who_wait_and_nothing_comes_after_it() -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue()
        waiting = [asyncio.create_task(anext(stream)) for _ in range(3)]
        await asyncio.sleep(0)
        stream.close()
        stream.close()
        stream.deliver(1)
        results = await asyncio.gather(*waiting, return_exceptions=True)
        assert [type(result) for result in results] == [StopAsyncIteration] * 3

    run(scenario())


def test_each_item_goes_to_one_of_several_who_wait() -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue()
        waiting = [asyncio.create_task(anext(stream)) for _ in range(3)]
        await asyncio.sleep(0)
        for number in range(3):
            stream.deliver(number)
        assert sorted(await asyncio.gather(*waiting)) == [0, 1, 2]

    run(scenario())


def test_one_who_is_cancelled_leaves_the_item_to_the_next() -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue()
        first, second = (asyncio.create_task(anext(stream)) for _ in range(2))
        await asyncio.sleep(0)
        stream.deliver(1)
        first.cancel()
        assert await second == 1
        with pytest.raises(asyncio.CancelledError):
            await first

    run(scenario())


def test_others_have_their_turn_although_there_is_always_an_item() -> None:
    async def scenario() -> None:
        stream: AsyncQueue[int] = AsyncQueue()
        stream.deliver(0)
        others: list[int] = []
        other = asyncio.create_task(asyncio.sleep(0, result=1))
        other.add_done_callback(lambda task: others.append(task.result()))
        async for number in stream:
            if others:
                return
            assert number < 1000
            stream.deliver(number + 1)

    run(scenario())
