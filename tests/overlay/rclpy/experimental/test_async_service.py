"""Services whose callbacks run in an asyncio loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import pytest
from helpers.loops import run, turns
from rclpy.experimental import AsyncClient, AsyncNode
from std_srvs.srv import Trigger

MakeAsyncNode = Callable[..., AsyncNode]


def _given_up(client: AsyncClient[Any, Any], monkeypatch: pytest.MonkeyPatch) -> asyncio.Event:
    """Set when the client learns that nobody will answer."""
    loop, event = asyncio.get_running_loop(), asyncio.Event()
    report = client.report_unanswered

    def told(reason: str) -> None:
        report(reason)
        loop.call_soon_threadsafe(event.set)

    monkeypatch.setattr(client, 'report_unanswered', told)
    return event


@pytest.mark.parametrize('concurrent', [False, True])
def test_requests_are_answered_one_after_the_other_unless_concurrent(
    make_async: MakeAsyncNode, concurrent: bool
) -> None:
    async def scenario() -> int:
        running = most = 0
        all_run, later_one_came = asyncio.Event(), asyncio.Event()

        async def callback(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            nonlocal running, most
            running += 1
            most = max(most, running)
            if most == 3:
                all_run.set()
            await (all_run if concurrent else later_one_came).wait()
            await turns()
            running -= 1
            return response

        def later(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            later_one_came.set()
            return response

        async with make_async() as node:
            node.create_service(Trigger, 'work', callback, concurrent=concurrent)
            node.create_service(Trigger, 'later', later)
            clients = [node.create_client(Trigger, name) for name in ('work', 'work', 'work', 'later')]
            for client in clients:
                await client.wait_for_service()
            await asyncio.gather(*(client.call(Trigger.Request()) for client in clients))
            return most

    assert run(scenario()) == (3 if concurrent else 1)


@pytest.mark.parametrize('concurrent', [False, True])
def test_an_error_of_the_callback_ends_the_node_and_the_call_of_another(
    make_async: MakeAsyncNode, concurrent: bool
) -> None:
    async def callback(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        raise ValueError('service')

    async def scenario() -> None:
        server, caller = make_async('server'), make_async('caller')
        server.create_service(Trigger, 'bad', callback, concurrent=concurrent)
        client = caller.create_client(Trigger, 'bad')
        async with caller, server:
            await client.wait_for_service()
            await client.call(Trigger.Request())

    with pytest.raises(ExceptionGroup) as raised:
        run(scenario())
    _, others = raised.value.split(ValueError)
    assert others is None


def test_destroying_the_node_tells_the_client_and_ends_the_callback(
    make_async: MakeAsyncNode, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        begun = asyncio.Event()
        ended = asyncio.Event()

        async def callback(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            begun.set()
            try:
                await asyncio.Event().wait()
            finally:
                ended.set()
            return response

        async with make_async('server') as server, make_async('caller') as caller:
            server.create_service(Trigger, 'slow', callback)
            client = caller.create_client(Trigger, 'slow')
            given_up = _given_up(client, monkeypatch)
            await client.wait_for_service()
            call = asyncio.create_task(client.call(Trigger.Request()))
            await begun.wait()
            server.destroy_node()
            await ended.wait()
            await given_up.wait()
            assert not call.done(), 'as in ROS 2 it waits on'
            call.cancel()

    run(scenario())
    assert 'no server answered' in capfd.readouterr().err


def test_a_callback_may_destroy_its_own_service_and_go_on(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        gone_on = asyncio.Event()

        async def callback(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            service.destroy()
            await turns()  # a cancellation would be raised here
            gone_on.set()
            return response

        async with make_async() as node:
            service = node.create_service(Trigger, 'once', callback)
            client = node.create_client(Trigger, 'once')
            await client.wait_for_service()
            call = asyncio.create_task(client.call(Trigger.Request()))
            await gone_on.wait()
            await turns()  # its answer is refused without a word
            call.cancel()
            assert node.count_services('once') == 0

    run(scenario())


def test_a_request_whose_callback_never_began_is_given_up(
    make_async: MakeAsyncNode, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        began: list[bool] = []
        called = asyncio.Event()

        async def answer(response: Trigger.Response) -> Trigger.Response:
            began.append(True)
            return response

        def callback(_: Trigger.Request, response: Trigger.Response) -> Coroutine[Any, Any, Trigger.Response]:
            called.set()  # wakes the scenario before the coroutine has its first turn
            return answer(response)

        async with make_async('caller') as caller:
            async with make_async('server') as server:
                server.create_service(Trigger, 'late', callback)
                client = caller.create_client(Trigger, 'late')
                given_up = _given_up(client, monkeypatch)
                await client.wait_for_service()
                call = asyncio.create_task(client.call(Trigger.Request()))
                await called.wait()
            await given_up.wait()
            call.cancel()
            assert began == []

    run(scenario())
    assert 'its callback was stopped' in capfd.readouterr().err
