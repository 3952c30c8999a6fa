"""Recorders and publishers."""

from __future__ import annotations

import asyncio
import threading

import pytest
import rclpy
from std_msgs.msg import String

from goalwire.testing import Graph, VirtualClock


def test_every_message_is_recorded_with_its_time(graph: Graph, clock: VirtualClock) -> None:
    chatter = graph.record(String, 'chatter')
    rclpy.init(args=[])
    node = rclpy.create_node('talker')
    publisher = node.create_publisher(String, 'chatter', 10)
    node.create_timer(2.0, lambda: publisher.publish(String(data='hello')))
    rclpy.spin_until_future_complete(node, rclpy.Future(), timeout_sec=7.0)
    assert chatter.messages == [String(data='hello')] * 3
    assert [later - chatter.times[0] for later in chatter.times] == [0.0, 2.0, 4.0]
    node.destroy_node()
    rclpy.shutdown()


def test_a_message_that_will_come_is_waited_for(graph: Graph, clock: VirtualClock) -> None:
    chatter, talker = graph.record(String, 'chatter'), graph.publisher(String, 'chatter')
    threading.Timer(3.0, talker.publish, [String(data='late')]).start()
    assert chatter.wait_for(timeout=4.0) == [String(data='late')]
    assert clock.elapsed == 3.0
    with pytest.raises(AssertionError, match=r"wanted 2 messages on '/chatter' within 5 s, got 1:\n  .*late"):
        chatter.wait_for(2)
    assert clock.elapsed == 8.0


def test_a_message_of_a_certain_kind_is_waited_for(graph: Graph) -> None:
    chatter, talker = graph.record(String, 'chatter'), graph.publisher(String, 'chatter')
    for word in 'abc':
        talker.publish(data=word)
    chatter.messages.wait_until(lambda messages: messages[-1].data == 'c')
    with pytest.raises(AssertionError, match="wanted a word more than c messages on '/chatter' within 1 s"):
        chatter.messages.wait_until(lambda messages: len(messages) > 3, 'a word more than c', timeout=1.0)
    chatter.messages.clear()
    assert not chatter.messages


def test_what_is_published_reaches_a_node_under_test(graph: Graph) -> None:
    talker = graph.publisher(String, '/chatter')
    with pytest.raises(AssertionError, match=r"wanted 1 subscriptions of '/chatter' within 5 s, got 0"):
        talker.wait_for_subscriber()
    heard: list[str] = []
    done = threading.Event()

    def hear(message: String) -> None:
        heard.append(message.data)
        done.set()

    def listener() -> rclpy.node.Node:
        node = rclpy.create_node('listener')
        node.create_subscription(String, 'chatter', hear, 10)
        return node

    graph.start(listener)
    talker.wait_for_subscriber()
    talker.publish(String(data='hello'))
    assert done.wait(1.0)
    assert heard == ['hello']


def test_a_publisher_that_will_come_is_waited_for(graph: Graph) -> None:
    chatter = graph.record(String, 'chatter')
    threading.Timer(1.0, graph.publisher, [String, 'chatter']).start()
    chatter.wait_for_publisher(timeout=2.0)
    with pytest.raises(AssertionError, match=r"wanted 2 publishers of '/chatter' within 5 s, got 1"):
        chatter.wait_for_publisher(2)


def test_in_a_coroutine_a_wait_that_would_block_its_loop_is_refused(graph: Graph) -> None:
    chatter = graph.record(String, 'chatter')

    async def play() -> list[String]:
        with pytest.raises(RuntimeError, match='would hold up the asyncio loop'):
            chatter.wait_for()
        async with graph.node('talker') as node:
            node.publisher(String, 'chatter').publish(data='hello')
            return await asyncio.to_thread(chatter.wait_for)

    assert asyncio.run(play()) == [String(data='hello')]
