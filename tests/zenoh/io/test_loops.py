"""An asyncio loop reads a session's wire on its own thread; another thread does only while it is busy."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from helpers.loops import LOOPS
from helpers.loops import run as run_in
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_sides import Ours, address

from goalwire.execution.asyncio.loop_waker import shared_waker
from goalwire.execution.asyncio.wire_reader import read_wire
from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT

RunLoop = Callable[[Coroutine[Any, Any, None]], None]


@pytest.fixture(params=LOOPS)
def run(request: pytest.FixtureRequest) -> RunLoop:
    """A function that runs a coroutine, on either loop."""
    return lambda coroutine: run_in(coroutine, request.param)


class Arrivals:
    """Messages on `k`, and the threads that brought them."""

    def __init__(self, side: Ours) -> None:
        self.threads: list[int] = []
        self.came = threading.Semaphore(0)
        self._waker = shared_waker(asyncio.get_running_loop())
        self._told: asyncio.Queue[bytes] = asyncio.Queue()
        side.protocol.declare_subscriber('k', self._take)

    def _take(self, sample: Sample) -> None:
        self.threads.append(threading.get_ident())
        self.came.release()
        payload = bytes(sample.payload or b'')
        self._waker.call(lambda: self._told.put_nowait(payload))

    async def next(self) -> bytes:
        return await self._told.get()


@pytest.fixture
def sides() -> Iterator[tuple[Ours, Ours]]:
    """Two linked sessions."""
    where = address()
    one = Ours('peer', listen=(where,))
    other = Ours('peer', connect=(where,))
    wait_for(lambda: one.protocol.links and other.protocol.links, 'the link')
    yield one, other
    other.close()
    one.close()


@asynccontextmanager
async def reading(side: Ours) -> AsyncIterator[None]:
    """Have the running loop read a session's wire."""
    loop = asyncio.get_running_loop()
    waker = shared_waker(loop)
    waker.open()
    leave = read_wire(loop, side.session.wire_poller)
    assert leave is not None
    try:
        yield
    finally:
        leave()
        waker.close()


def put(other: Ours, payload: bytes) -> None:
    """Put on `k`, once the subscriber there is known."""
    wait_for(lambda: any(each.peer.subscribers.has_meeting('k') for each in other.protocol.links), 'it')
    other.put('k', payload)


def test_messages_come_on_the_loops_own_thread(sides: tuple[Ours, Ours], run: RunLoop) -> None:
    one, other = sides

    async def main() -> None:
        async with reading(one):
            arrivals = Arrivals(one)
            await asyncio.to_thread(put, other, b'0')
            assert await arrivals.next() == b'0'
            number = 0
            # Another thread looks now and then whether the loop is busy, and may be first.
            while threading.get_ident() not in arrivals.threads:
                number += 1
                other.put('k', b'%d' % number)
                assert await arrivals.next() == b'%d' % number

    run(main())


def test_while_the_loop_is_busy_another_thread_reads(sides: tuple[Ours, Ours], run: RunLoop) -> None:
    one, other = sides

    async def main() -> None:
        async with reading(one):
            arrivals = Arrivals(one)
            await asyncio.to_thread(put, other, b'0')
            await arrivals.next()
            arrivals.came = threading.Semaphore(0)
            other.put('k', b'1')
            assert arrivals.came.acquire(timeout=PATIENCE)  # the loop's thread blocks here
            assert arrivals.threads[-1] != threading.get_ident()
            assert await arrivals.next() == b'1'

    run(main())


def test_the_last_that_leaves_ends_it(sides: tuple[Ours, Ours], run: RunLoop) -> None:
    one, other = sides

    async def main() -> None:
        async with reading(one):
            async with reading(one):
                pass
            arrivals = Arrivals(one)
            await asyncio.to_thread(put, other, b'0')
            await arrivals.next()
        here = threading.get_ident()
        arrivals.threads.clear()
        await asyncio.to_thread(put, other, b'1')
        assert await arrivals.next() == b'1'
        assert arrivals.threads != [here]

    run(main())


def test_a_thread_that_blocks_beside_a_loop_is_served(sides: tuple[Ours, Ours], run: RunLoop) -> None:
    one, other = sides
    other.serve('q', b'answer ')
    wait_for(
        lambda: any(each.peer.queryables.has_meeting('q') for each in one.protocol.links), 'the queryable'
    )

    async def main() -> None:
        async with reading(one):
            answers = await asyncio.to_thread(one.ask, 'q', b'1')
            assert await asyncio.to_thread(answers.wait)
            assert await asyncio.to_thread(one.session.wait_until, lambda: bool(one.protocol.links), PATIENCE)

    run(main())


def test_a_loop_that_waits_for_room_reads_meanwhile(sides: tuple[Ours, Ours], run: RunLoop) -> None:
    one, other = sides
    heard = other.subscribe('big')

    async def main() -> None:
        async with reading(one):
            wait_for(
                lambda: any(each.peer.subscribers.has_meeting('big') for each in one.protocol.links), 'it'
            )
            for _ in range(8):
                one.put('big', bytes(QUEUE_LIMIT))

    run(main())
    assert [len(payload or b'') for _, payload in heard.wait(8)] == [QUEUE_LIMIT] * 8


def test_a_session_may_close_while_a_loop_reads(run: RunLoop) -> None:
    async def main() -> None:
        side = Ours('peer', listen=(address(),))
        async with reading(side):
            await asyncio.to_thread(side.close)
            await asyncio.sleep(0)
        assert read_wire(asyncio.get_running_loop(), side.session.wire_poller) is None

    run(main())


def test_what_has_no_descriptor_is_read_by_a_thread() -> None:
    side = Ours('peer', listen=(address(),), portable=True)

    async def main() -> None:
        loop = asyncio.get_running_loop()
        assert read_wire(loop, side.session.wire_poller) is None
        assert read_wire(loop, None) is None

    run_in(main())
    side.close()
