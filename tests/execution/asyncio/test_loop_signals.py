"""Signals wake the main thread's loop while a node is open on it, even if they come just before its wait."""

from __future__ import annotations

import asyncio
import ctypes
import operator
import os
import select
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

import pytest

from goalwire.execution.asyncio.loop_waker import shared_waker

if not sys.platform.startswith('linux'):
    pytest.skip('epoll, and a signal that is sent from C', allow_module_level=True)

_LONG_S = 20


class LatePoll:
    """An epoll object that gets a signal before its next wait, after the last instruction of Python."""

    def __init__(self, epoll: select.epoll) -> None:
        self._epoll = epoll
        self.woken: bool | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._epoll, name)

    def poll(self, timeout: float | None = None, most: int = -1) -> object:
        if self.woken is not None or (timeout is not None and timeout < 1):
            return self._epoll.poll(timeout, most)
        kill = partial(ctypes.CDLL(None).kill, os.getpid(), signal.SIGUSR1)
        # map and call are functions of C: no instruction of Python runs between the signal and the wait.
        _, ready = map(operator.call, (kill, partial(self._epoll.poll, timeout, most)))
        self.woken = bool(ready)
        return ready


async def _is_woken() -> bool:
    """Return whether a signal that comes just before the wait of the running loop ends that wait."""
    loop = asyncio.get_running_loop()
    selector = vars(loop)['_selector']
    late = LatePoll(selector._selector)
    handled = asyncio.Event()
    signal.signal(signal.SIGUSR1, lambda _number, _frame: loop.call_soon(handled.set))
    loop.call_later(_LONG_S, handled.set)
    selector._selector = late
    try:
        await handled.wait()
    finally:
        selector._selector = late._epoll
    assert late.woken is not None
    return late.woken


@asynccontextmanager
async def _open_node() -> AsyncIterator[None]:
    """Open and close the waker of the running loop, as a node does."""
    waker = shared_waker(asyncio.get_running_loop())
    waker.open()
    try:
        yield
    finally:
        waker.close()


@pytest.fixture(autouse=True)
def descriptor() -> Iterator[None]:
    """Keep the handler of SIGUSR1, and look for a wake-up descriptor that was left installed."""
    before = signal.getsignal(signal.SIGUSR1)
    yield
    signal.signal(signal.SIGUSR1, before)
    assert signal.set_wakeup_fd(-1) == -1


def test_a_signal_just_before_the_wait_wakes_the_loop() -> None:
    async def program() -> bool:
        async with _open_node(), _open_node():
            return await _is_woken()

    assert asyncio.run(program())


def test_a_second_loop_of_the_main_thread_is_woken_too() -> None:
    """The first was closed within the node's block."""
    loop = asyncio.new_event_loop()
    waker = shared_waker(loop)
    loop.run_until_complete(_call(waker.open))
    loop.close()

    async def program() -> bool:
        async with _open_node():
            return await _is_woken()

    assert asyncio.run(program())


def test_a_descriptor_of_the_programs_own_stays() -> None:
    reader, writer = socket.socketpair()
    with reader, writer:
        writer.setblocking(False)
        signal.set_wakeup_fd(writer.fileno())

        async def program() -> None:
            async with _open_node():
                pass

        asyncio.run(program())
        assert signal.set_wakeup_fd(-1) == writer.fileno()


def test_a_handler_of_the_loops_own_stays() -> None:
    """asyncio installs its own descriptor for it, after ours or before."""

    async def program() -> None:
        loop = asyncio.get_running_loop()
        came = asyncio.Event()
        async with _open_node():
            loop.add_signal_handler(signal.SIGUSR1, came.set)
        async with _open_node():
            os.kill(os.getpid(), signal.SIGUSR1)
            await asyncio.wait_for(came.wait(), _LONG_S)
        loop.remove_signal_handler(signal.SIGUSR1)

    asyncio.run(program())


def test_loops_of_other_threads_are_left_alone() -> None:
    async def program() -> int:
        async with _open_node():
            return 1

    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(asyncio.run, program()).result(_LONG_S) == 1


async def _call(function: Callable[[], object]) -> None:
    function()
