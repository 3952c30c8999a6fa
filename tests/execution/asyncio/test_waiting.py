"""Coroutines that wait for other threads."""

from __future__ import annotations

import asyncio
import sys
import threading
from types import ModuleType

import pytest
from helpers.loops import LOOPS, run

from goalwire.execution.asyncio.waiting import AsyncQueue, AsyncWaiter, delay_s, in_thread, settle
from goalwire.execution.future import Future
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.waiters import running_loop

MS = 1_000_000


@pytest.mark.parametrize('loop', LOOPS)
def test_a_waiter_is_woken_by_another_thread(loop: str) -> None:
    async def scenario() -> None:
        waiter = AsyncWaiter()
        thread = threading.Thread(target=waiter.wake)
        thread.start()
        await waiter.wait()
        thread.join()

    run(scenario(), loop)


def test_no_loop_runs_while_another_thread_is_importing_asyncio(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'asyncio.events', ModuleType('asyncio.events'))
    assert running_loop() is None


def test_a_wake_up_that_comes_first_ends_the_next_wait_and_counts_once() -> None:
    async def scenario() -> None:
        waiter = AsyncWaiter()
        waiter.wake()
        waiter.wake()
        await waiter.wait()
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.01):
                await waiter.wait()

    run(scenario())


@pytest.mark.parametrize('loop', LOOPS)
def test_a_wait_ends_at_its_timeout_and_not_before(loop: str) -> None:
    async def scenario() -> None:
        for timeout in (1, 400_000, 3_300_000):
            start = STEADY.now()
            await AsyncWaiter().wait(timeout)
            assert STEADY.now() - start >= timeout

    run(scenario(), loop)


def test_a_cancelled_wait_leaves_the_waiter_usable() -> None:
    async def scenario() -> None:
        waiter = AsyncWaiter()
        task = asyncio.create_task(waiter.wait())
        await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        waiter.wake()
        await waiter.wait()

    run(scenario())


def test_a_waiter_outlives_its_loop_without_harm() -> None:
    async def scenario() -> AsyncWaiter:
        waiter = AsyncWaiter()
        task = asyncio.create_task(waiter.wait())
        await asyncio.sleep(0)
        task.cancel()
        return waiter

    run(scenario()).wake()


def test_no_wake_up_is_lost_between_two_threads() -> None:
    async def scenario() -> None:
        there, back = AsyncWaiter(), threading.Semaphore(0)

        def answer() -> None:
            for _ in range(2000):
                back.acquire()
                there.wake()

        thread = threading.Thread(target=answer)
        thread.start()
        for _ in range(2000):
            back.release()
            await there.wait()
        thread.join()

    run(scenario())


@pytest.mark.parametrize(
    ('missing_ns', 'delay'), [(-5, 0.0), (0, 0.0), (1, 0.001), (MS, 0.001), (MS + 1, 0.002)]
)
def test_a_delay_is_rounded_up_to_whole_milliseconds(missing_ns: int, delay: float) -> None:
    assert delay_s(missing_ns) == delay


def test_a_future_that_another_thread_completes_is_settled() -> None:
    async def scenario() -> None:
        future: Future[int] = Future()
        thread = threading.Thread(target=future.set_result, args=(1,))
        thread.start()
        assert await settle(future, ShutdownSignal())
        thread.join()
        assert await settle(future, ShutdownSignal())
        assert future.result() == 1

    run(scenario())


def test_the_end_of_the_lifeline_ends_the_wait_for_a_future() -> None:
    async def scenario() -> None:
        future: Future[int] = Future()
        shutdown_signal = ShutdownSignal()
        asyncio.get_running_loop().call_soon(shutdown_signal.end, 'test')
        assert not await settle(future, shutdown_signal)
        assert not await settle(future, shutdown_signal), 'it had ended before'

    run(scenario())


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
