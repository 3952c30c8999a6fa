"""Subscriptions whose callbacks run in an asyncio loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from helpers.loops import LOOPS, run, turns
from rclpy.experimental import AsyncNode
from rclpy.serialization import serialize_message
from rclpy.subscription import MessageInfo
from rclpy.subscription_content_filter_options import ContentFilterOptions
from std_msgs.msg import Int64

MakeAsyncNode = Callable[..., AsyncNode]


@pytest.mark.parametrize('loop', LOOPS)
def test_messages_reach_a_plain_callback_in_order(make_async: MakeAsyncNode, loop: str) -> None:
    async def scenario() -> list[int]:
        heard: list[int] = []
        enough = asyncio.Event()

        def callback(message: Int64) -> None:
            heard.append(message.data)
            if len(heard) == 5:
                enough.set()

        async with make_async() as node:
            node.create_subscription(Int64, 'count', callback, 10)
            publisher = node.create_publisher(Int64, 'count', 10)
            for number in range(5):
                publisher.publish(Int64(data=number))
            await enough.wait()
            return heard

    assert run(scenario(), loop) == list(range(5))


@pytest.mark.parametrize('concurrent', [False, True])
def test_callbacks_overlap_only_where_concurrent(make_async: MakeAsyncNode, concurrent: bool) -> None:
    async def scenario() -> list[str]:
        seen: list[str] = []
        enough, second_began, second_came = asyncio.Event(), asyncio.Event(), asyncio.Event()

        async def callback(message: Int64) -> None:
            seen.append(f'begin {message.data}')
            if message.data == 2:
                second_began.set()
            await (second_began if concurrent else second_came).wait()
            await turns()
            seen.append(f'end {message.data}')
            if len(seen) == 4:
                enough.set()

        def another(message: Int64) -> None:
            if message.data == 2:
                second_came.set()

        async with make_async() as node:
            node.create_subscription(Int64, 'count', callback, 10, concurrent=concurrent)
            node.create_subscription(Int64, 'count', another, 10)
            publisher = node.create_publisher(Int64, 'count', 10)
            for number in (1, 2):
                publisher.publish(Int64(data=number))
            await enough.wait()
            return seen

    seen = run(scenario())
    assert sorted(seen) == ['begin 1', 'begin 2', 'end 1', 'end 2']
    assert seen[:2] == ['begin 1', 'begin 2' if concurrent else 'end 1']


def test_raw_messages_and_their_info(make_async: MakeAsyncNode) -> None:
    async def scenario() -> tuple[bytes, MessageInfo]:
        heard: asyncio.Future[tuple[bytes, MessageInfo]] = asyncio.get_running_loop().create_future()

        def callback(message: bytes, info: MessageInfo) -> None:
            heard.set_result((message, info))

        async with make_async() as node:
            node.create_subscription(Int64, 'count', callback, 10, raw=True)
            node.create_publisher(Int64, 'count', 10).publish(Int64(data=7))
            return await heard

    message, info = run(scenario())
    assert message == serialize_message(Int64(data=7))
    assert info['source_timestamp'] <= info['received_timestamp']


def test_what_was_queued_before_the_block_is_delivered_in_it(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        heard = asyncio.Event()
        node = make_async()
        node.create_subscription(Int64, 'count', lambda _: heard.set(), 10)
        node.create_publisher(Int64, 'count', 10).publish(Int64())
        async with node:
            await heard.wait()

    run(scenario())


def test_a_destroyed_subscription_hears_nothing_and_its_callback_is_cancelled(
    make_async: MakeAsyncNode,
) -> None:
    async def scenario() -> None:
        begun, cancelled = asyncio.Event(), asyncio.Event()

        async def callback(_: Int64) -> None:
            begun.set()
            try:
                await asyncio.Event().wait()
            finally:
                cancelled.set()

        async with make_async() as node:
            subscription = node.create_subscription(Int64, 'count', callback, 10)
            publisher = node.create_publisher(Int64, 'count', 10)
            publisher.publish(Int64())
            await begun.wait()
            subscription.destroy()
            subscription.destroy()
            await cancelled.wait()
            begun.clear()
            heard = asyncio.Event()
            another = node.create_subscription(Int64, 'count', lambda _: heard.set(), 10)
            publisher.publish(Int64())
            await heard.wait()
            await turns()
            assert not begun.is_set()
            assert list(node.subscriptions) == [another]
            publisher.destroy()
            assert publisher not in node.publishers

    run(scenario())


def test_a_content_filter_is_not_swallowed(
    make_async: MakeAsyncNode, capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_async()
    options = ContentFilterOptions(filter_expression='data > %0', expression_parameters=['3'])
    subscription = node.create_subscription(Int64, 'count', print, 10, content_filter_options=options)
    assert not subscription.is_cft_enabled
    assert "'/count': this wire cannot filter by content ('data > %0')" in capfd.readouterr().err
