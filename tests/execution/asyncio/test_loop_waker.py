"""Calls from any thread on an asyncio loop's, and tasks that sleep until one comes."""

from __future__ import annotations

import asyncio
import contextvars
import gc
import os
import resource
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from errno import EMFILE
from fcntl import F_DUPFD_CLOEXEC, fcntl
from functools import partial
from pathlib import Path
from weakref import ref

import pytest
from helpers.loops import LOOPS, run

from goalwire.execution.asyncio.fd_selector import FdSelector
from goalwire.execution.asyncio.loop_waker import (
    AsyncioLoopWaker,
    DirectFuture,
    LoopWaker,
    shared_waker,
    waker_of,
)
from goalwire.execution.asyncio.stepped_loop import SteppedLoop
from goalwire.execution.time.steady_clock import STEADY

ROUNDS = 2000
EAGER = getattr(asyncio, 'eager_task_factory', None)


@contextmanager
def opened(waker: AsyncioLoopWaker) -> Iterator[None]:
    waker.open()
    try:
        yield
    finally:
        waker.close()


FILES = Path('/proc/self/fd')

BEYOND_SELECT = 1500


@contextmanager
def many_files() -> Iterator[None]:
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)


needs_proc = pytest.mark.skipif(not FILES.is_dir(), reason='counts the files in /proc')


def open_files() -> int:
    return len(list(FILES.iterdir()))


@pytest.mark.parametrize('loop', LOOPS)
@pytest.mark.parametrize('is_open', [True, False])
def test_calls_from_another_thread_come_in_order_on_the_loops(loop: str, is_open: bool) -> None:
    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        seen: list[tuple[int, int]] = []
        over = asyncio.Event()

        def see(number: int) -> None:
            seen.append((number, threading.get_ident()))

        def call_all() -> None:
            for number in range(ROUNDS):
                waker.call(partial(see, number))
            waker.call(over.set)

        if is_open:
            waker.open()
        thread = threading.Thread(target=call_all)
        thread.start()
        await over.wait()
        thread.join()
        if is_open:
            waker.close()
        assert seen == [(number, threading.get_ident()) for number in range(ROUNDS)]

    run(scenario(), loop)


@pytest.mark.parametrize('loop', LOOPS)
def test_no_call_is_lost_where_the_bridge_opens_and_closes_meanwhile(loop: str) -> None:
    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        counts = [0, 0]
        over = asyncio.Event()

        def call_all(index: int) -> None:
            def count() -> None:
                counts[index] += 1
                if counts == [ROUNDS, ROUNDS]:
                    over.set()

            for _ in range(ROUNDS):
                waker.call(count)

        threads = [threading.Thread(target=call_all, args=(index,)) for index in range(2)]
        for thread in threads:
            thread.start()
        while not over.is_set():
            with opened(waker):
                await asyncio.sleep(0)
            await asyncio.sleep(0)
        for thread in threads:
            thread.join()

    run(scenario(), loop)


@needs_proc
def test_an_open_bridge_holds_one_file_until_its_last_user_closes_it() -> None:
    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        before = open_files()
        with opened(waker), opened(waker):
            assert open_files() <= before + 1
            waker.call(bool)
        assert open_files() == before
        with opened(waker):
            await asyncio.sleep(0)
        assert open_files() == before

    run(scenario())


@needs_proc
def test_a_bridge_that_is_rung_while_it_closes_leaves_no_file() -> None:
    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        waker = shared_waker(loop)
        before = open_files()
        answered = loop.create_future()
        with opened(waker):
            ringing = threading.Thread(target=waker.call, args=(lambda: answered.set_result(1),))
            ringing.start()
            ringing.join()  # the loop has not heard of it
        assert open_files() == before
        assert await answered == 1

    run(scenario())


@needs_proc
def test_a_bridge_with_a_descriptor_beyond_select_closes_while_it_is_rung(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """select() takes the first 1024 alone."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if most <= BEYOND_SELECT:
        pytest.skip('so many files cannot be opened here')
    real = os.eventfd

    def far_out(*how: int) -> int:
        near = real(*how)
        try:
            return fcntl(near, F_DUPFD_CLOEXEC, BEYOND_SELECT)
        finally:
            os.close(near)

    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        over = asyncio.Event()
        with opened(waker):
            waker.call(over.set)
        await over.wait()

    monkeypatch.setattr(os, 'eventfd', far_out)
    with many_files():
        run(scenario())


@pytest.mark.parametrize('what', ['add_reader', 'eventfd'])
def test_a_loop_that_can_have_no_eventfd_is_called_all_the_same(
    monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    def cannot(*_: object) -> None:
        raise NotImplementedError if what == 'add_reader' else OSError(EMFILE, 'Too many open files')

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        monkeypatch.setattr(loop if what == 'add_reader' else os, what, cannot, raising=False)
        waker = shared_waker(loop)
        over = asyncio.Event()
        with opened(waker):
            thread = threading.Thread(target=waker.call, args=(over.set,))
            thread.start()
            await over.wait()
            thread.join()

    run(scenario())


def test_what_a_call_raises_takes_no_other_call_its_turn() -> None:
    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        told: list[object] = []
        loop.set_exception_handler(lambda _, context: told.append(context['exception']))
        waker = shared_waker(loop)
        over = asyncio.Event()
        error = ValueError('of a call')

        def fail() -> None:
            raise error

        waker.call(fail)
        waker.call(over.set)
        await over.wait()
        assert told == [error]

    run(scenario())


def test_a_call_that_calls_again_lets_the_loop_have_its_turn() -> None:
    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        again = 0

        def call_again() -> None:
            nonlocal again
            again += 1
            waker.call(call_again)

        waker.call(call_again)
        for _ in range(10):
            await asyncio.sleep(0)
        assert 0 < again < 100

    run(scenario())


def test_a_closed_loop_is_called_in_vain_and_kept_by_nobody() -> None:
    loop = asyncio.new_event_loop()
    waker = shared_waker(loop)
    assert waker_of(loop) is waker
    loop.close()
    waker.call(bool)
    waker.call(bool)
    assert not waker.calls
    gone = ref(loop)
    del loop
    gc.collect()
    assert gone() is None
    waker.call(bool)
    assert not waker.calls


def test_a_call_that_a_stepped_loop_finds_before_its_wake_up_leaves_the_next_ones_theirs() -> None:
    class Overtaken(deque[Callable[[], object]]):
        """A queue whose loop makes a step between a call's append and the check whether the loop sleeps."""

        def append(self, function: Callable[[], object]) -> None:
            super().append(function)
            loop.step()

    rings, seen, fd_selector = list[None](), list[int](), FdSelector(lambda: None)
    loop = SteppedLoop(fd_selector, STEADY, lambda: rings.append(None))
    waker = loop.goalwire_waker
    waker.call(partial(seen.append, 1))
    waker.calls = Overtaken(waker.calls)
    waker.call(partial(seen.append, 2))
    waker.calls = deque(waker.calls)
    loop.step()  # which the second one has rung for
    rings.clear()
    waker.call(partial(seen.append, 3))
    assert rings == [None]
    loop.step()
    assert seen == [1, 2, 3]
    loop.close()
    fd_selector.close()


# -- Pause


@pytest.mark.parametrize('loop', LOOPS)
@pytest.mark.parametrize('is_open', [True, False])
def test_a_pause_ends_when_another_thread_says_so(loop: str, is_open: bool) -> None:
    async def scenario() -> None:
        waker = shared_waker(asyncio.get_running_loop())
        go, pauses = threading.Semaphore(0), list[DirectFuture]()

        def answer() -> None:
            for _ in range(ROUNDS):
                go.acquire()
                waker.call(pauses.pop().resume)

        if is_open:
            waker.open()
        thread = threading.Thread(target=answer)
        thread.start()
        for _ in range(ROUNDS):
            direct = DirectFuture()
            pauses.append(direct)
            go.release()
            await direct
        thread.join()
        if is_open:
            waker.close()

    run(scenario(), loop)


def test_tasks_of_every_make_sleep_in_pauses() -> None:
    """asyncio has them in C and in Python (which nest_asyncio takes), and from 3.12 on eager ones."""

    async def sleeper() -> asyncio.Task[object] | None:
        direct = DirectFuture()
        thread = threading.Thread(target=shared_waker(asyncio.get_running_loop()).call, args=(direct.resume,))
        thread.start()
        await direct
        thread.join()
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.001):
                await DirectFuture()
        return asyncio.current_task()

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        pure = asyncio.tasks._PyTask  # type: ignore[attr-defined]
        makes = [None, lambda loop, it, **how: pure(it, loop=loop, **how), EAGER]
        if sys.version_info >= (3, 14):  # there asyncio.current_task does not know tasks in Python
            del makes[1]
        for make in makes:
            loop.set_task_factory(make)
            task = loop.create_task(sleeper())
            assert await task is task

    run(scenario())


@pytest.mark.parametrize('loop', LOOPS)
def test_a_task_wakes_from_a_pause_as_itself_in_its_own_context(loop: str) -> None:
    mark: contextvars.ContextVar[str] = contextvars.ContextVar('mark', default='of nobody')

    async def sleeper(direct: DirectFuture) -> tuple[object, str]:
        mark.set('of the sleeper')
        await direct
        return asyncio.current_task(), mark.get()

    async def scenario() -> None:
        direct = DirectFuture()
        task = asyncio.create_task(sleeper(direct))
        await asyncio.sleep(0)
        asyncio.get_running_loop().call_soon(direct.resume)
        assert await task == (task, 'of the sleeper')
        assert mark.get() == 'of nobody'

    run(scenario(), loop)


@pytest.mark.parametrize('loop', LOOPS)
def test_a_task_in_a_pause_can_be_cancelled_and_time_out(loop: str) -> None:
    async def scenario() -> None:
        direct = DirectFuture()
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.001):
                await direct
        assert direct.cancelled()
        direct.resume()  # too late
        task = asyncio.ensure_future(asyncio.wait_for(DirectFuture(), 10))
        await asyncio.sleep(0)
        task.cancel('enough')
        with pytest.raises(asyncio.CancelledError):
            await task

    run(scenario(), loop)


def test_a_task_that_is_cancelled_before_it_sleeps_does_not_sleep() -> None:
    async def sleeper() -> None:
        task = asyncio.current_task()
        assert task is not None
        task.cancel()
        await DirectFuture()

    async def scenario() -> None:
        with pytest.raises(asyncio.CancelledError):
            await asyncio.create_task(sleeper())

    run(scenario())


def test_a_pause_that_is_over_is_none() -> None:
    async def scenario() -> None:
        direct = DirectFuture()
        direct.resume()
        direct.resume()
        await direct
        assert not direct.cancel()

    run(scenario())


def test_a_task_that_ends_the_program_does_so_from_a_pause() -> None:
    async def sleeper(direct: DirectFuture) -> None:
        await direct
        raise KeyboardInterrupt

    async def scenario() -> None:
        loop = asyncio.get_running_loop()
        direct = DirectFuture()
        task = asyncio.create_task(sleeper(direct))
        await asyncio.sleep(0)
        shared_waker(loop).call(direct.resume)
        await task

    with pytest.raises(KeyboardInterrupt):
        run(scenario())


def test_a_task_that_was_resumed_leaves_no_circle() -> None:
    async def scenario() -> None:
        direct = DirectFuture()
        asyncio.get_running_loop().call_soon(direct.resume)
        await direct
        gone = ref(direct)
        del direct
        await asyncio.sleep(0)  # this came out of `resume`
        assert gone() is None

    gc.disable()
    try:
        run(scenario())
    finally:
        gc.enable()


def test_a_lane_brings_its_own_bridge() -> None:
    loop = asyncio.new_event_loop()
    try:
        loop.goalwire_waker = waker = LoopWaker(bool)  # type: ignore[attr-defined]
        assert waker_of(loop) is waker
    finally:
        loop.close()
