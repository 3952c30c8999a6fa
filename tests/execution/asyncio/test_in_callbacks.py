"""A coroutine callback may await any asyncio awaitable (execution rule 2)."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any

import pytest
from helpers.execution import SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY

GROUPS: list[Callable[[], CallbackGroup]] = [MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup]


@pytest.fixture(params=GROUPS)
def run(
    request: pytest.FixtureRequest, executor: Executor, node: SmallNode
) -> Callable[[Callable[[], Coroutine[Any, Any, Any]]], Any]:
    """Runs a coroutine function as a callback, and returns what it returned."""
    group: CallbackGroup = request.param()
    executor.add_node(node)

    def run_in_callback(callback: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
        result: Future[Any] = Future()

        async def carry() -> None:
            result.set_result(await callback())

        GuardCondition(carry, group, work_queue=node.work_queue).trigger()
        executor.spin_until_future_complete(result, PATIENCE)
        assert result.done()
        return result.result()

    return run_in_callback


Run = Callable[[Callable[[], Coroutine[Any, Any, Any]]], Any]


def test_sleep(run: Run) -> None:
    async def callback() -> float:
        begun = STEADY.now()
        await asyncio.sleep(0.03)
        return (STEADY.now() - begun) / 1e9

    assert 0.03 <= run(callback) < PATIENCE


def test_timeout(run: Run) -> None:
    async def callback() -> str:
        try:
            async with asyncio.timeout(0.01):
                await asyncio.sleep(3600)
        except TimeoutError:
            return 'timed out'
        return 'slept'

    assert run(callback) == 'timed out'


def test_task_group_and_gather(run: Run) -> None:
    async def square(number: int) -> int:
        await asyncio.sleep(0.001)  # each has to wait
        return number * number

    async def callback() -> tuple[list[int], list[int]]:
        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(square(number)) for number in range(4)]
        return [task.result() for task in tasks], list(await asyncio.gather(*map(square, range(4))))

    assert run(callback) == ([0, 1, 4, 9], [0, 1, 4, 9])


def test_event_queue_and_lock(run: Run) -> None:
    async def callback() -> int:
        event, queue, lock = asyncio.Event(), asyncio.Queue[int](), asyncio.Lock()

        async def produce() -> None:
            async with lock:
                await queue.put(3)
            event.set()

        producer = asyncio.create_task(produce())
        await event.wait()
        await producer
        async with lock:
            return await queue.get()

    assert run(callback) == 3


def test_to_thread(run: Run) -> None:
    async def callback() -> bool:
        here = threading.get_ident()
        return await asyncio.to_thread(threading.get_ident) != here

    assert run(callback)


def test_asynchronous_generators_are_closed(run: Run) -> None:
    closed: list[bool] = []

    async def numbers() -> AsyncIterator[int]:
        try:
            for number in range(10):
                yield number
                await asyncio.sleep(0)
        finally:
            closed.append(True)

    async def callback() -> int:
        iterator = numbers()
        async for number in iterator:
            if number == 3:
                break
        await iterator.aclose()  # type: ignore[attr-defined]
        return number

    assert run(callback) == 3
    assert closed == [True]


def test_streams_over_a_socket(run: Run) -> None:
    async def callback() -> bytes:
        async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write((await reader.readline()).upper())
            await writer.drain()
            writer.close()
            await writer.wait_closed()

        server = await asyncio.start_server(echo, '127.0.0.1', 0)
        port = server.sockets[0].getsockname()[1]
        reader, writer = await asyncio.open_connection('127.0.0.1', port)
        writer.write(b'hello\n')
        await writer.drain()
        answer = await reader.read()
        writer.close()
        await writer.wait_closed()
        server.close()
        await server.wait_closed()
        return answer

    assert run(callback) == b'HELLO\n'


@pytest.mark.skipif(sys.platform == 'win32', reason='asyncio runs subprocesses on its proactor loop there')
def test_subprocess(run: Run) -> None:
    async def callback() -> bytes:
        process = await asyncio.create_subprocess_exec(
            sys.executable, '-c', 'print(6 * 7)', stdout=subprocess.PIPE
        )
        output, _ = await process.communicate()
        return output.strip()

    assert run(callback) == b'42'


def test_our_futures_and_asyncios_together(run: Run) -> None:
    async def callback() -> list[object]:
        ours: Future[int] = Future()
        asyncio.get_running_loop().call_later(0.005, ours.set_result, 1)

        async def wait() -> int | None:
            return await ours

        return list(await asyncio.gather(wait(), asyncio.sleep(0.01, result=2)))

    assert run(callback) == [1, 2]


def test_an_event_set_by_a_plain_callback_wakes_a_coroutine(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    group = ReentrantCallbackGroup()
    event = asyncio.Event()
    waiting = threading.Event()
    woken: Future[bool] = Future()

    async def waits() -> None:
        waiting.set()
        woken.set_result(await event.wait())

    waiter = GuardCondition(waits, group, work_queue=node.work_queue)
    setter = GuardCondition(event.set, group, work_queue=node.work_queue)
    with Spinning(executor):
        waiter.trigger()
        assert soon(waiting)
        setter.trigger()
        assert woken.wait(STEADY.now() + 10**10)


def test_call_soon_threadsafe_wakes_an_idle_executor(executor: Executor) -> None:
    loop: Future[asyncio.AbstractEventLoop] = Future()
    stop: Future[int] = Future()

    async def hold() -> int | None:
        loop.set_result(asyncio.get_running_loop())
        return await stop

    _ = executor.create_task(hold)
    with Spinning(executor):
        assert loop.wait(STEADY.now() + 10**10)
        running = loop.result()
        assert running is not None
        running.call_soon_threadsafe(stop.set_result, 1)
        assert stop.wait(STEADY.now() + 10**10)


def test_background_tasks_go_on_after_their_callback(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    finished: Future[int] = Future()
    tasks = []

    async def background() -> None:
        await asyncio.sleep(0.01)  # its callback is over meanwhile
        finished.set_result(1)

    async def callback() -> None:
        tasks.append(asyncio.create_task(background()))

    GuardCondition(callback, None, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(finished, PATIENCE)
    assert finished.result() == 1


def test_callbacks_share_asyncio_objects(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    queue: asyncio.Queue[int] = asyncio.Queue()
    got: Future[int] = Future()

    async def consume() -> None:
        got.set_result(await queue.get() + await queue.get())

    async def produce() -> None:
        await queue.put(1)
        queue.put_nowait(2)

    for callback in (consume, produce):
        GuardCondition(callback, MutuallyExclusiveCallbackGroup(), work_queue=node.work_queue).trigger()
    single.spin_until_future_complete(got, PATIENCE)
    assert got.result() == 3


def test_a_watched_socket_keeps_an_idle_executor_asleep_until_bytes_come(executor: Executor) -> None:
    port: Future[int] = Future()
    got: Future[bytes] = Future()

    async def serve() -> None:
        connected: asyncio.Queue[bytes] = asyncio.Queue()

        async def read(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await connected.put(await reader.readline())
            writer.close()
            await writer.wait_closed()

        server = await asyncio.start_server(read, '127.0.0.1', 0)
        port.set_result(server.sockets[0].getsockname()[1])
        got.set_result(await connected.get())
        server.close()
        await server.wait_closed()

    import socket

    task = executor.create_task(serve)
    with Spinning(executor) as spinning:
        assert port.wait(STEADY.now() + 10**10)
        before = time.process_time()
        assert not spinning.ended.wait(0.2)
        assert time.process_time() - before < 0.05
        with socket.create_connection(('127.0.0.1', port.result() or 0)) as client:
            client.sendall(b'late\n')
            assert got.wait(STEADY.now() + 10**10)
        assert got.result() == b'late\n'
        assert task.wait(STEADY.now() + 10**10)


def test_work_is_run_while_a_socket_is_watched(executor: Executor) -> None:
    listening, stop = threading.Event(), Future[None]()

    async def serve() -> None:
        server = await asyncio.start_server(lambda _, __: None, '127.0.0.1', 0)
        listening.set()
        await stop
        server.close()
        await server.wait_closed()

    served = executor.create_task(serve)
    with Spinning(executor):
        assert soon(listening)
        for number in range(200):
            task = executor.create_task(lambda number=number: number)
            assert task.wait(STEADY.now() + 10**10)
        stop.set_result(None)
        assert served.wait(STEADY.now() + 10**10)


@pytest.mark.skipif(sys.platform == 'win32', reason='asyncio has no signal handlers there')
def test_add_signal_handler(single: SingleThreadedExecutor) -> None:
    async def main() -> str:
        loop = asyncio.get_running_loop()
        got = asyncio.Event()
        loop.add_signal_handler(signal.SIGUSR1, got.set)
        os.kill(os.getpid(), signal.SIGUSR1)
        await got.wait()
        loop.remove_signal_handler(signal.SIGUSR1)
        return 'got it'

    task = single.create_task(main)
    single.spin_until_future_complete(task, PATIENCE)
    assert task.result() == 'got it'


def test_a_thousand_coroutine_callbacks_at_once(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    group = ReentrantCallbackGroup()
    count, lock = 0, threading.Lock()
    everything = threading.Event()

    async def callback() -> None:
        nonlocal count
        await asyncio.sleep(0.01)  # all thousand sleep at the same time
        with lock:
            count += 1
        if count == 1000:
            everything.set()

    guards = [GuardCondition(callback, group, work_queue=node.work_queue) for _ in range(1000)]
    with Spinning(executor):
        for guard in guards:
            guard.trigger()
        assert soon(everything)


def test_a_sleep_that_falls_due_while_other_work_runs_is_not_lost(single: SingleThreadedExecutor) -> None:
    """Due between the end of asyncio's own look at its timers and the executor's look for the next one."""

    async def main() -> int:
        for _ in range(300):
            await asyncio.sleep(0.00001)
        return 1

    tasks = [single.create_task(main) for _ in range(10)]
    for task in tasks:
        single.spin_until_future_complete(task, PATIENCE)
        assert task.result() == 1
