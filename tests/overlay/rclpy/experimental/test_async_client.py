"""Service calls that are awaited."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from helpers.loops import LOOPS, run, turns
from rclpy.exceptions import InvalidHandle
from rclpy.experimental import AsyncNode
from std_srvs.srv import SetBool, Trigger

MakeAsyncNode = Callable[..., AsyncNode]


def _echo(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.success = request.data
    return response


@pytest.mark.parametrize('loop', LOOPS)
def test_a_call_returns_the_response(make_async: MakeAsyncNode, loop: str) -> None:
    async def scenario() -> None:
        async with make_async('server') as server, make_async('caller') as caller:
            server.create_service(SetBool, 'echo', _echo)
            client = caller.create_client(SetBool, 'echo')
            await client.wait_for_service()
            assert client.service_is_ready()
            for data in (True, False):
                assert (await client.call(SetBool.Request(data=data))).success is data
            assert client.pending == {}

    run(scenario(), loop)


def test_a_wait_for_service_is_woken_by_the_server(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            client = node.create_client(SetBool, 'late')
            waiting = asyncio.create_task(client.wait_for_service(check_interval=60.0))
            node.create_service(SetBool, 'other', _echo)
            await node.create_client(SetBool, 'other').wait_for_service()
            assert not waiting.done()
            node.create_service(SetBool, 'late', _echo)
            await waiting

    run(scenario())


def test_destroying_the_client_ends_what_waits_for_it(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            client = node.create_client(SetBool, 'never')
            call = asyncio.create_task(client.call(SetBool.Request()))
            wait = asyncio.create_task(client.wait_for_service())
            await turns()  # both wait
            client.destroy()
            client.destroy()
            await asyncio.wait([call])
            assert call.cancelled()
            with pytest.raises(InvalidHandle):
                await wait
            with pytest.raises(RuntimeError, match="'/never': the client was destroyed"):
                await client.call(SetBool.Request())
            assert list(node.clients) == []

    run(scenario())


def test_calls_at_the_same_time_get_their_own_answers(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        barrier = asyncio.Barrier(3)

        async def number(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
            await barrier.wait()
            response.message = str(request.data)
            return response

        async with make_async() as node:
            node.create_service(SetBool, 'number', number, concurrent=True)
            client = node.create_client(SetBool, 'number')
            await client.wait_for_service()
            wanted = [True, False, True]
            calls = [client.call(SetBool.Request(data=data)) for data in wanted]
            assert [answer.message for answer in await asyncio.gather(*calls)] == [
                str(data) for data in wanted
            ]

    run(scenario())


def test_a_call_that_timed_out_leaves_nothing_and_the_next_one_succeeds(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        patient = [True]

        async def slow(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            if patient.pop() if patient else False:
                await asyncio.Event().wait()
            response.success = True
            return response

        async with make_async() as node:
            node.create_service(Trigger, 'slow', slow, concurrent=True)
            client = node.create_client(Trigger, 'slow')
            await client.wait_for_service()
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.02):
                    await client.call(Trigger.Request())
            assert client.pending == {}
            assert (await client.call(Trigger.Request())).success

    run(scenario())


def test_what_is_no_request_is_refused(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            client = node.create_client(SetBool, 'service')
            with pytest.raises(TypeError, match=r'expected .*SetBool\.Request'):
                await client.call(Trigger.Request())  # type: ignore[arg-type]

    run(scenario())
