"""Publishers, and subscriptions as async iterators."""

from __future__ import annotations

import asyncio

import pytest
from helpers.collector import Collector
from helpers.loops import Play
from helpers.patience import PATIENCE
from std_msgs.msg import Int64, String

import goalwire
from goalwire.errors import DeadlineError, EncodeError, InvalidHandle
from goalwire.logging import add_sink

pytestmark = pytest.mark.also_on_dds


def test_messages_come_in_order(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('listener') as listener:
            numbers = listener.subscription(Int64, 'count', qos=100)
            publisher = talker.publisher(Int64, 'count', qos=100)
            await publisher.wait_for_subscribers(timeout=PATIENCE)
            assert (publisher.subscribers(), publisher.name) == (1, '/count')
            for number in range(50):
                publisher.publish(data=number)
            publisher.publish(Int64(data=50))
            assert [(await anext(numbers)).data for _ in range(51)] == list(range(51))
            assert numbers.info is not None
            assert 0 < numbers.info['source_timestamp'] <= numbers.info['received_timestamp']

    play(scenario)


def test_a_raw_subscription_gives_the_bytes(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('talker') as talker, goalwire.Node('listener') as listener:
            texts = listener.subscription(String, 'text', raw=True)
            publisher = talker.publisher(String, 'text')
            await publisher.wait_for_subscribers(timeout=PATIENCE)
            publisher.publish(data='abc')
            payload = await anext(texts)
            assert payload[:4] == b'\x00\x01\x00\x00'
            assert payload[8:12] == b'abc\x00'

    play(scenario)


def test_a_slow_reader_gets_the_latest_and_a_count_of_what_was_dropped(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            numbers = node.subscription(Int64, 'count', qos=3)
            end = node.subscription(Int64, 'end')
            publisher, last = node.publisher(Int64, 'count'), node.publisher(Int64, 'end')
            await publisher.wait_for_subscribers(timeout=PATIENCE)
            await last.wait_for_subscribers(timeout=PATIENCE)
            for number in range(10):
                publisher.publish(data=number)
            last.publish()
            await anext(end)
            assert [(await anext(numbers)).data for _ in range(3)] == [7, 8, 9]
            assert numbers.dropped == 7

    play(scenario)


def test_closing_a_subscription_ends_its_loop_after_what_waited(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            publisher = node.publisher(String, 'chat')
            with node.subscription(String, 'chat') as chat:
                await publisher.wait_for_subscribers(timeout=PATIENCE)
                publisher.publish(data='last')
                message = await anext(chat)
            assert [message.data async for message in chat] == []
            assert message.data == 'last'
            with pytest.raises(InvalidHandle):
                chat.publishers()

    play(scenario)


def test_leaving_the_node_ends_the_loops_of_other_tasks(play: Play) -> None:
    async def scenario() -> None:
        async def listen() -> list[String]:
            return [message async for message in chat]

        async with goalwire.Node('node') as node:
            chat = node.subscription(String, 'chat')
            listening = asyncio.create_task(listen())
            await asyncio.sleep(0)
        assert await listening == []

    play(scenario)


def test_what_cannot_be_published_is_refused(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            publisher = node.publisher(Int64, 'count')
            with pytest.raises(TypeError, match='give a Int64 or its fields'):
                publisher.publish(Int64(), data=1)
            with pytest.raises(EncodeError):
                publisher.publish(data=2**63)
            with pytest.raises(TypeError, match='expected'):
                publisher.publish(String())  # type: ignore[arg-type]
            with pytest.raises(DeadlineError, match="topic '/count': too few subscribers came; waited"):
                await publisher.wait_for_subscribers(timeout=0.01)
            subscription = node.subscription(Int64, 'count')
            await subscription.wait_for_publishers(timeout=PATIENCE)
            with pytest.raises(DeadlineError, match="topic '/count': too few publishers came; waited"):
                await subscription.wait_for_publishers(2, timeout=0.01)
            publisher.close()
            publisher.close()
            with pytest.raises(InvalidHandle):
                publisher.publish(data=1)

    play(scenario)


def test_qos_that_does_not_fit_is_warned_of(play: Play) -> None:
    warnings: Collector[str] = Collector()

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            best_effort = goalwire.QoS(reliability=goalwire.ReliabilityPolicy.BEST_EFFORT)
            node.publisher(String, 'chat', qos=best_effort)
            node.subscription(String, 'chat')
            await asyncio.to_thread(warnings.expect, 2)

    with add_sink(lambda record: warnings(record.message)):
        play(scenario)
    assert all('incompatible QoS' in text for text in warnings.items)
