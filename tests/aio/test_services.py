"""Services and clients, and the ways in which a call ends."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest
from helpers.collector import Collector
from helpers.loops import Play, turns
from helpers.patience import PATIENCE
from std_srvs.srv import SetBool, Trigger

import goalwire
from goalwire.errors import (
    CallError,
    DeadlineError,
    InvalidHandle,
    NoServerError,
    ServerFailedError,
    ServerLostError,
)
from goalwire.logging import add_sink
from goalwire.testing import VirtualClock

from .conftest import ON_MEMORY

pytestmark = pytest.mark.also_on_dds


async def switch(request: SetBool.Request) -> SetBool.Response:
    await asyncio.sleep(0)
    return SetBool.Response(success=request.data, message='switched')


def plain(request: SetBool.Request) -> SetBool.Response:
    return SetBool.Response(success=request.data, message='switched')


@pytest.mark.parametrize('handler', [switch, plain])
def test_a_call_is_answered(
    play: Play, handler: Callable[[SetBool.Request], SetBool.Response | Awaitable[SetBool.Response]]
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand') as hand:
            lamp.service(SetBool, 'switch', handler)
            client = hand.client(SetBool, 'switch')
            assert (await client.call(data=True, timeout=PATIENCE)).success
            response = await client.call(SetBool.Request(data=False))
            assert (response.success, response.message) == (False, 'switched')

    play(scenario)


def test_a_call_waits_for_a_server_that_comes_later(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('hand') as hand:
            calling = asyncio.create_task(hand.client(SetBool, 'switch').call(data=True, timeout=PATIENCE))
            await turns()  # it has found no server
            async with goalwire.Node('lamp') as lamp:
                lamp.service(SetBool, 'switch', switch)
                assert (await calling).success

    play(scenario)


def test_a_server_in_another_namespace_is_named(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand', namespace='/left') as hand:
            lamp.service(SetBool, 'switch', switch)
            await hand.client(SetBool, '/switch').wait_for_server(timeout=PATIENCE)
            client = hand.client(SetBool, 'switch')
            for ask in (client.call(timeout=0.03), client.wait_for_server(timeout=0.03)):
                with pytest.raises(NoServerError, match=r"did you mean '/switch' of the node '/lamp'\?$"):
                    await ask

    play(scenario)


def test_without_a_server_a_call_ends_at_its_deadline(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('hand', namespace='/left') as hand:
            client = hand.client(SetBool, 'switch')
            with pytest.raises(
                NoServerError,
                match=r"^service '/left/switch': no server came in domain \d+ \(\w+\); waited \d\.\d{3} s$",
            ) as e:
                await client.call(timeout=0.03)
            assert isinstance(e.value, TimeoutError)
            assert e.value.name == '/left/switch'
            assert 0.03 <= e.value.waited < 1
            with pytest.raises(NoServerError):
                await client.wait_for_server(timeout=0)

    play(scenario)


def test_a_slow_server_is_told_from_none(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand') as hand:

            async def never(_: Trigger.Request) -> Trigger.Response:
                await asyncio.Event().wait()
                return Trigger.Response()

            lamp.service(Trigger, 'hang', never)
            client = hand.client(Trigger, 'hang')
            await client.wait_for_server(timeout=PATIENCE)
            with pytest.raises(
                DeadlineError, match="service '/hang' of node '/lamp': no answer came in time"
            ) as e:
                await client.call(timeout=0.03)
            assert e.value.peers == ('/lamp',)
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.01):
                    await client.call()
            assert not client._core.pending

    play(scenario)


def test_a_server_that_goes_away_fails_the_calls_that_wait_at_once(play: Play) -> None:
    async def scenario() -> None:
        began = asyncio.Event()
        gone = asyncio.Event()

        async def never(_: Trigger.Request) -> Trigger.Response:
            began.set()
            await asyncio.Event().wait()
            return Trigger.Response()

        async def serve() -> None:
            async with goalwire.Node('lamp') as lamp:
                with lamp.service(Trigger, 'hang', never):
                    await gone.wait()

        async with goalwire.Node('hand') as hand:
            serving = asyncio.create_task(serve())
            calling = asyncio.create_task(hand.client(Trigger, 'hang').call(timeout=PATIENCE))
            await began.wait()
            gone.set()
            with pytest.raises(
                CallError, match=r"service '/hang' of node '/lamp': (the server went away|its callback was)"
            ) as e:
                await calling
            assert isinstance(e.value, ServerLostError | ServerFailedError)
            assert e.value.waited < 5
            await serving

    play(scenario)


def test_a_handler_that_fails_is_logged_and_told_and_the_node_goes_on(play: Play) -> None:
    records: Collector[str] = Collector()

    async def fail(request: SetBool.Request) -> SetBool.Response:
        if request.data:
            raise KeyError('bulb')
        return SetBool.Response()

    def fail_at_once(_: SetBool.Request) -> SetBool.Response:
        raise KeyError('fuse')

    async def scenario() -> None:
        async with goalwire.Node('lamp') as node:
            node.service(SetBool, 'later', fail)
            node.service(SetBool, 'at_once', fail_at_once)
            node.service(SetBool, 'wrong', lambda _: 'on')  # type: ignore[arg-type,return-value]
            later = node.client(SetBool, 'later')
            for client in (later, node.client(SetBool, 'at_once'), node.client(SetBool, 'wrong')):
                with pytest.raises(ServerFailedError, match='its callback failed'):
                    await client.call(data=True, timeout=PATIENCE)
            assert not (await later.call(data=False, timeout=PATIENCE)).success

    with add_sink(lambda record: records(record.message)):
        play(scenario)
    failures = [text for text in records.items if 'its handler failed' in text]
    assert len(failures) == 3
    assert "Service '/later': its handler failed\nTraceback" in failures[0]
    assert failures[0].endswith("KeyError: 'bulb'")


@ON_MEMORY
@pytest.mark.parametrize(('concurrent', 'most'), [(True, 3), (False, 1)])
def test_requests_are_handled_beside_each_other_unless_told_otherwise(
    play: Play, clock: VirtualClock, concurrent: bool, most: int
) -> None:
    async def scenario() -> None:
        running: list[int] = []
        seen: list[int] = []

        async def handle(request: SetBool.Request) -> SetBool.Response:
            running.append(1)
            seen.append(len(running))
            await asyncio.sleep(0.02)
            running.pop()
            return SetBool.Response(success=request.data)

        async with goalwire.Node('node') as node:
            node.service(SetBool, 'switch', handle, concurrent=concurrent)
            client = node.client(SetBool, 'switch')
            await client.wait_for_server(timeout=PATIENCE)
            async with asyncio.TaskGroup() as group:
                for _ in range(3):
                    group.create_task(client.call(data=True, timeout=PATIENCE))
            assert max(seen) == most

    play(scenario)


def test_closing_a_client_ends_its_calls(play: Play) -> None:
    async def scenario() -> None:
        async def never(_: Trigger.Request) -> Trigger.Response:
            began.set()
            await asyncio.Event().wait()
            return Trigger.Response()

        began = asyncio.Event()
        async with goalwire.Node('node') as node:
            node.service(Trigger, 'hang', never)
            client = node.client(Trigger, 'hang')
            calling = asyncio.create_task(client.call())
            await began.wait()
            client.close()
            with pytest.raises(InvalidHandle):
                await calling
            with pytest.raises(InvalidHandle):
                await client.call()

    play(scenario)


@ON_MEMORY
def test_a_deadline_begins_with_the_call(play: Play, clock: VirtualClock) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            client = node.client(Trigger, 'late')
            with pytest.raises(ValueError, match='nan'):
                await client.call(timeout=float('nan'))
            calling = asyncio.create_task(client.call(timeout=0.2))
            await asyncio.sleep(0.1)

            async def never(_: Trigger.Request) -> Trigger.Response:
                await asyncio.Event().wait()
                return Trigger.Response()

            node.service(Trigger, 'late', never)
            with pytest.raises(DeadlineError):
                await calling
            assert clock.elapsed == pytest.approx(0.2)

    play(scenario)
