"""rclpy.wait_for_message: one message, waited for without spinning."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest
from helpers.collector import Collector
from helpers.patience import wait_for
from helpers.spinning import MakeNode, Spin, wait_until
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32, String

if TYPE_CHECKING:
    from rclpy.publisher import Publisher

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Teller:
    """Publishes on `chat` when somebody has begun to listen, from a thread of its own."""

    def __init__(self, node: Node, *payloads: String | bytes) -> None:
        self._publisher: Publisher[String] = node.create_publisher(String, 'chat', 10)
        self._payloads = payloads
        self._node = node
        self._thread = threading.Thread(target=self._tell)

    def _tell(self) -> None:
        wait_until(self._node.context, lambda: self._publisher.get_subscription_count() == 1)
        for payload in self._payloads:
            self._publisher.publish(payload)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._thread.join()


def test_the_next_message_is_returned_and_the_subscription_is_gone(make_node: MakeNode) -> None:
    node = make_node()
    with Teller(make_node('teller'), String(data='hello')):
        assert wait_for_message(String, node, 'chat', time_to_wait=10) == (True, String(data='hello'))
    assert list(node.subscriptions) == []
    wait_until(node.context, lambda: node.count_subscribers('chat') == 0)


def test_without_a_time_it_waits_until_a_message_comes(make_node: MakeNode) -> None:
    node = make_node()
    with Teller(make_node('teller'), String(data='at last')):
        found, message = wait_for_message(String, node, 'chat')
    assert found
    assert message == String(data='at last')


@pytest.mark.parametrize('seconds', [0, 0.05])
def test_silence_ends_with_the_time(make_node: MakeNode, seconds: float) -> None:
    assert wait_for_message(String, make_node(), 'none', time_to_wait=seconds) == (False, None)


def test_shutdown_ends_it(make_node: MakeNode, context: Context) -> None:
    node = make_node()
    others = len(node.handle.owned())

    def end_it() -> None:
        wait_for(lambda: len(node.handle.owned()) > others, 'the subscription')
        context.try_shutdown()

    thread = threading.Thread(target=end_it)
    thread.start()
    assert wait_for_message(String, node, 'none') == (False, None)
    thread.join()


def test_a_message_from_before_comes_with_a_profile_that_asks_for_it(make_node: MakeNode) -> None:
    node = make_node()
    node.create_publisher(String, 'map', LATCHED).publish(String(data='old'))
    result = wait_for_message(String, node, 'map', qos_profile=LATCHED, time_to_wait=10)
    assert result == (True, String(data='old'))


def test_a_message_that_cannot_be_read_is_passed_over(make_node: MakeNode) -> None:
    node = make_node()
    with Teller(make_node('teller'), b'\x00\x01\x00\x00\xff', String(data='fine')):
        assert wait_for_message(String, node, 'chat', time_to_wait=10) == (True, String(data='fine'))


def test_it_works_beside_a_thread_that_spins_the_node(make_node: MakeNode, spin: Spin) -> None:
    node = make_node()
    spin(node)
    for word in ('one', 'two', 'three'):
        teller = make_node(f'teller_{word}')
        with Teller(teller, String(data=word)):
            assert wait_for_message(String, node, 'chat', time_to_wait=10) == (True, String(data=word))
        teller.destroy_node()


@pytest.mark.parametrize('threads', [1, 2])
def test_it_works_inside_a_callback(make_node: MakeNode, spin: Spin, threads: int) -> None:
    node, heard = make_node(), Collector[String | None]()

    def ask() -> None:
        once.cancel()
        heard(wait_for_message(String, node, 'chat', time_to_wait=10)[1])

    once = node.create_timer(0.0, ask)
    with Teller(make_node('teller'), String(data='hello')):
        spin(node, threads=threads)
        assert heard.expect() == [String(data='hello')]


def test_what_no_subscription_can_be_made_of_is_refused_as_there(make_node: MakeNode) -> None:
    node = make_node()
    with pytest.raises(Exception, match='topic name'):
        wait_for_message(Int32, node, 'no such', time_to_wait=0)
    node.destroy_node()
    with pytest.raises(Exception, match='cannot use Destroyable'):
        wait_for_message(Int32, node, 'chat', time_to_wait=0)
