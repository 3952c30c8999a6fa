"""What is said where nothing can ever happen again."""

from __future__ import annotations

import asyncio
import threading

import pytest

import goalwire
from goalwire.testing import DeadlockError, Graph, VirtualClock


def test_where_everything_waits_for_ever_it_is_said_who_waits_where(clock: VirtualClock) -> None:
    async def mission() -> None:
        await asyncio.Event().wait()

    def serve() -> None:
        gate.wait()

    gate = threading.Event()
    server = threading.Thread(target=serve, name='server')
    server.start()
    with pytest.raises(DeadlockError) as caught:
        asyncio.run(mission())
    text = str(caught.value)
    assert "thread 'MainThread' waits" in text
    assert "thread 'server' waits" in text
    assert f'{__file__}' in text
    assert 'in serve' in text
    assert 'in mission' in text
    gate.set()
    server.join()


def test_a_deadlock_is_told_to_the_thread_of_the_block(clock: VirtualClock) -> None:
    gate = threading.Event()
    thread = threading.Thread(target=gate.wait)
    thread.start()
    with pytest.raises(DeadlockError):
        thread.join()
    gate.set()
    thread.join()


def test_a_node_in_a_loop_brings_no_outside_world_in(clock: VirtualClock, gw_graph: Graph) -> None:
    async def mission() -> None:
        async with goalwire.Node('worker') as node, asyncio.timeout(10):
            await node.clock.sleep(5)
        async with goalwire.Node('worker'):
            await asyncio.Event().wait()

    with pytest.raises(DeadlockError):
        asyncio.run(mission())


def test_the_innermost_places_of_the_program_come_first(clock: VirtualClock) -> None:
    def outer() -> None:
        inner()

    def inner() -> None:
        threading.Event().wait()

    with pytest.raises(DeadlockError) as caught:
        outer()
    text = str(caught.value)
    assert text.index('in inner') < text.index('in outer')
    assert 'threading.py' not in text
