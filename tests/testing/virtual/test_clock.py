"""Virtual time as programs see it: sleeps, locks, threads, queues, asyncio."""

from __future__ import annotations

import asyncio
import os
import queue
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from goalwire.errors import LocalError
from goalwire.testing import VirtualClock


def test_an_hour_of_sleep_takes_no_time_and_shows_on_every_clock(clock: VirtualClock) -> None:
    before = (time.time(), time.monotonic(), time.perf_counter(), time.process_time())
    time.sleep(3600.0)
    after = (time.time(), time.monotonic(), time.perf_counter(), time.process_time())
    *virtual, real = (later - earlier for earlier, later in zip(before, after, strict=True))
    assert virtual == [3600.0] * 3
    assert real < 1.0
    assert clock.elapsed == 3600.0
    assert time.time_ns() == round(time.time() * 1e9)
    assert time.monotonic_ns() == time.perf_counter_ns() == round(time.monotonic() * 1e9)


def test_each_run_begins_at_the_same_time() -> None:
    def now() -> tuple[int, int]:
        with VirtualClock():
            time.sleep(1.0)
            return time.time_ns(), time.monotonic_ns()

    assert now() == now()


def test_two_clocks_do_not_go_at_once(clock: VirtualClock) -> None:
    with pytest.raises(LocalError, match='leave its block first'), VirtualClock():
        pass


def test_threads_sleep_side_by_side_and_wake_in_the_order_of_their_times(clock: VirtualClock) -> None:
    woken = []

    def sleep(seconds: float) -> None:
        time.sleep(seconds)
        woken.append((seconds, clock.elapsed))

    threads = [threading.Thread(target=sleep, args=[seconds]) for seconds in (3.0, 1.0, 2.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert woken == [(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]


def test_a_join_ends_in_time_where_the_thread_does_not(clock: VirtualClock) -> None:
    thread = threading.Thread(target=time.sleep, args=[10.0])
    thread.start()
    thread.join(timeout=4.0)
    assert (thread.is_alive(), clock.elapsed) == (True, 4.0)
    thread.join()
    assert (thread.is_alive(), clock.elapsed) == (False, 10.0)


def test_an_event_is_waited_for_until_it_is_set_or_the_time_is_over(clock: VirtualClock) -> None:
    event = threading.Event()
    assert not event.wait(timeout=2.0)
    assert clock.elapsed == 2.0
    threading.Timer(3.0, event.set).start()
    assert event.wait(timeout=10.0)
    assert clock.elapsed == 5.0


def test_conditions_locks_and_semaphores_wait_in_virtual_time(clock: VirtualClock) -> None:
    lock, rlock, semaphore = threading.Lock(), threading.RLock(), threading.Semaphore(0)
    condition = threading.Condition()

    def hold() -> None:
        with lock, rlock:
            time.sleep(5.0)
        semaphore.release()
        with condition:
            condition.notify_all()

    holder = threading.Thread(target=hold)
    holder.start()
    time.sleep(1.0)
    assert not lock.acquire(timeout=1.0)
    assert not rlock.acquire(timeout=1.0)
    assert clock.elapsed == 3.0
    with lock:
        assert clock.elapsed == 5.0
    assert semaphore.acquire(timeout=1.0)
    with condition:
        assert not condition.wait_for(lambda: False, timeout=2.0)
    holder.join()
    assert clock.elapsed == 7.0


def test_queues_of_every_kind_wait_in_virtual_time(clock: VirtualClock) -> None:
    kinds: list[queue.Queue[int] | queue.SimpleQueue[int]] = [queue.Queue(), queue.SimpleQueue()]
    for each in kinds:
        began = clock.elapsed
        with pytest.raises(queue.Empty):
            each.get(timeout=2.0)
        threading.Timer(1.0, each.put, [7]).start()
        assert each.get(timeout=2.0) == 7
        assert clock.elapsed - began == 3.0


def test_a_pool_of_threads_works_in_virtual_time(clock: VirtualClock) -> None:
    with ThreadPoolExecutor(max_workers=2) as pool:
        futures = [pool.submit(time.sleep, 1.0) for _ in range(4)]
        with pytest.raises(TimeoutError):
            futures[3].result(timeout=1.5)
        futures[3].result()
    assert clock.elapsed == 2.0


def test_asyncio_runs_in_virtual_time(clock: VirtualClock) -> None:
    async def main() -> None:
        async with asyncio.TaskGroup() as tasks:
            for seconds in (1.0, 7.5):
                tasks.create_task(asyncio.sleep(seconds))
        assert clock.elapsed == 7.5
        await asyncio.to_thread(time.sleep, 2.5)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(5.0):
                await asyncio.Event().wait()
        threading.Timer(1.0, loop.call_soon_threadsafe, [event.set]).start()
        await event.wait()

    loop = asyncio.new_event_loop()
    event = asyncio.Event()
    loop.run_until_complete(main())
    loop.run_until_complete(loop.shutdown_default_executor())
    loop.close()
    assert clock.elapsed == 16.0


def test_streams_of_asyncio_work_while_time_is_virtual(clock: VirtualClock) -> None:
    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(await reader.readline())
        writer.close()

    async def main() -> bytes:
        server = await asyncio.start_server(echo, '127.0.0.1', 0)
        async with server:
            reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
            writer.write(b'hello\n')
            line = await reader.readline()
            writer.close()
            return line

    assert asyncio.run(main()) == b'hello\n'


def test_what_blocks_in_the_real_world_holds_time_up(clock: VirtualClock) -> None:
    thread = threading.Thread(target=time.sleep, args=[100.0], daemon=True)
    thread.start()
    subprocess.run([sys.executable, '-c', 'pass'], check=True)
    assert clock.elapsed == 0.0
    thread.join()


@pytest.mark.parametrize('step', [0.0, 0.25])
def test_a_loop_that_only_looks_at_the_time_comes_to_its_end(clock: VirtualClock, step: float) -> None:
    other = threading.Thread(target=time.sleep, args=[0.3])
    other.start()
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        if step:
            time.sleep(step)
    assert 0.5 <= clock.elapsed < 0.55
    assert not other.is_alive()


def test_a_thread_that_yields_lets_the_others_run(clock: VirtualClock) -> None:
    seen: list[int] = []

    def count() -> None:
        for number in range(3):
            seen.append(number)
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    while len(seen) < 3:
        time.sleep(0)
    thread.join()
    assert clock.elapsed == 0.0


def test_threads_that_go_on_after_the_block_go_on_in_real_time() -> None:
    order = []

    def go_on() -> None:
        order.append('began')
        assert not never.wait(timeout=1000.05)
        order.append('woke')

    with VirtualClock():
        never = threading.Event()
        thread = threading.Thread(target=go_on)
        thread.start()
        time.sleep(1000.0)
    thread.join(timeout=10.0)
    assert order == ['began', 'woke']


def test_a_thread_of_before_lives_in_real_time() -> None:
    asked, answered, told = threading.Event(), threading.Event(), []

    def tell() -> None:
        asked.wait(10.0)
        told.append(time.monotonic())
        answered.set()

    thread = threading.Thread(target=tell)
    thread.start()
    real = time.monotonic()
    with VirtualClock():
        time.sleep(1e6)
        asked.set()
        thread.join()
        assert time.monotonic() - told[0] > 1e5
    assert 0.0 <= told[0] - real < 10.0


def test_an_error_of_a_thread_does_not_stop_time(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        time.sleep(1.0)
        raise ValueError('boom')

    reported: list[threading.ExceptHookArgs] = []
    monkeypatch.setattr(threading, 'excepthook', reported.append)

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join()
    time.sleep(1.0)
    assert clock.elapsed == 2.0
    assert str(reported[0].exc_value) == 'boom'


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='no fork here')
def test_a_forked_child_lives_in_real_time(clock: VirtualClock) -> None:
    time.sleep(1e6)
    virtual = time.monotonic()
    child = os.fork()
    if not child:
        began = time.monotonic()
        time.sleep(0.01)
        os._exit(0 if 0.01 <= time.monotonic() - began < 10.0 and abs(began - virtual) > 1.0 else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert clock.elapsed == 1e6
