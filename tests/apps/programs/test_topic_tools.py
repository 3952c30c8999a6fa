"""relay, throttle, drop and mux, between publishers and subscribers of this process."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from apps.programs.conftest import Run
from helpers.patience import PATIENCE
from rcl_interfaces.srv import ListParameters
from rclpy.node import Node
from std_msgs.msg import Int32
from topic_tools_interfaces.srv import MuxAdd, MuxDelete, MuxList, MuxSelect


@pytest.fixture
def node(isolated: dict[str, str]) -> Iterator[Node]:
    with rclpy.init():
        yield Node('tester')


def _count_through(node: Node, source: str, target: str, count: int) -> list[int]:
    """Publish 0, 1, 2 ... and -1 once both ends are known; returns a list of what comes out."""
    heard: list[int] = []
    node.create_subscription(Int32, target, lambda message: heard.append(message.data), 100)
    publisher = node.create_publisher(Int32, source, 100)
    _wait(node, lambda: publisher.get_subscription_count() > 0)
    _wait(node, lambda: node.count_publishers(target) > 0)
    for number in range(count):
        publisher.publish(Int32(data=number))
    publisher.publish(Int32(data=-1))
    return heard


def _wait(node: Node, is_so: Any) -> None:
    end = node.get_clock().now().nanoseconds + int(PATIENCE * 1e9)
    while not is_so():
        assert node.get_clock().now().nanoseconds < end
        rclpy.spin_once(node, timeout_sec=0.1)


def _call(node: Node, kind: type, name: str, request: Any) -> Any:
    client: Any = node.create_client(kind, name)
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    return future.result()


def test_relay_passes_everything_on(run: Run, node: Node) -> None:
    run('topic_tools', 'relay', 'numbers')
    heard = _count_through(node, 'numbers', 'numbers_relay', 5)
    _wait(node, lambda: -1 in heard)
    assert heard == [0, 1, 2, 3, 4, -1]


def test_drop_takes_two_of_every_three(run: Run, node: Node) -> None:
    run('topic_tools', 'drop', 'numbers', '2', '3', 'rest')
    heard = _count_through(node, 'numbers', 'rest', 8)
    _wait(node, lambda: -1 in heard)
    assert heard == [2, 5, -1]


def test_throttle_passes_one_of_a_burst(run: Run, node: Node) -> None:
    run('topic_tools', 'throttle', 'messages', 'numbers', '0.01')
    heard = _count_through(node, 'numbers', 'numbers_throttle', 5)
    # The request goes the way of the numbers, its answer the way of what is passed on: it comes last.
    _call(node, ListParameters, 'throttle/list_parameters', ListParameters.Request())
    assert heard == [0]


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (
            ['throttle', 'messages', 'numbers', 'often'],
            "MESSAGES_PER_S is 'often': it must be a number above 0",
        ),
        (['throttle'], "it needs the word 'messages' or 'bytes', a topic and a rate"),
        (['drop', 'numbers', '4', '3'], '4 of every 3 messages cannot be dropped'),
        (['relay'], 'no input topic: name the topic to listen to'),
        (['mux', 'out'], 'it needs an output and at least one input'),
    ],
)
def test_what_does_not_fit_is_told_with_the_usage(run: Run, words: list[str], reason: str) -> None:
    program = run('topic_tools', *words)
    assert program.wait() == 1
    assert f'{words[0]}: {reason}\nusage: {words[0]} ' in program.output


def test_a_mux_passes_the_selected_input(run: Run, node: Node) -> None:
    run('topic_tools', 'mux', 'out', 'left', 'right')
    assert _call(node, MuxList, 'mux/list', MuxList.Request()).topics == ['/left', '/right']
    selected = _call(node, MuxSelect, 'mux/select', MuxSelect.Request(topic='right'))
    assert (selected.success, selected.prev_topic) == (True, '/left')
    assert not _call(node, MuxSelect, 'mux/select', MuxSelect.Request(topic='nowhere')).success
    assert not _call(node, MuxDelete, 'mux/delete', MuxDelete.Request(topic='right')).success
    assert _call(node, MuxAdd, 'mux/add', MuxAdd.Request(topic='third')).success
    heard = _count_through(node, 'right', 'out', 2)
    _wait(node, lambda: -1 in heard)
    assert heard == [0, 1, -1]
