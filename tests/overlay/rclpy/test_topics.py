"""Topics between nodes: callbacks, queues, raw messages, exceptions, the end of an entity."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.collector import Collector
from helpers.spinning import MakeNode, Spin, wait_until
from helpers.wires import DDS
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from rclpy.subscription import MessageInfo, Subscription
from rclpy.task import Future
from rclpy.utilities import get_rmw_implementation_identifier
from std_msgs.msg import Int32, String
from std_srvs.srv import SetBool

from goalwire.errors import EncodeError

pytestmark = pytest.mark.also_on_dds


def meet(publisher: Publisher[Any], subscription: Subscription[Any], context: Context) -> None:
    wait_until(
        context,
        lambda: publisher.get_subscription_count() > 0 and subscription.get_publisher_count() > 0,
    )


def numbers(messages: list[Int32]) -> list[int]:
    return [message.data for message in messages]


def test_messages_arrive_in_order(context: Context, make_node: MakeNode, executor: Executor) -> None:
    node, came, all_here = make_node(), list[int](), Future[bool]()

    def callback(message: Int32) -> None:
        came.append(message.data)
        if message.data == 49:
            all_here.set_result(True)

    publisher = node.create_publisher(Int32, 'numbers', 100)
    meet(publisher, node.create_subscription(Int32, 'numbers', callback, 100), context)
    for number in range(50):
        publisher.publish(Int32(data=number))
    executor.add_node(node)
    executor.spin_until_future_complete(all_here, 10)
    assert came == list(range(50))


def test_a_callback_of_two_arguments_learns_when_and_as_which_message_it_was_sent(
    context: Context, make_node: MakeNode, spin: Spin, transport_name: str
) -> None:
    node, came = make_node(), Collector[tuple[str, MessageInfo]]()
    publisher = node.create_publisher(String, 'chat', 10)
    subscription = node.create_subscription(
        String, 'chat', lambda message, info: came((message.data, info)), 10
    )
    meet(publisher, subscription, context)
    spin(node)
    before = node.get_clock().now().nanoseconds
    publisher.publish(String(data='a'))
    publisher.publish(String(data='b'))
    (first, one), (second, two) = came.expect(2)
    assert (first, second) == ('a', 'b')
    assert before - 1_000_000 <= one['source_timestamp'] <= two['source_timestamp']
    assert one['received_timestamp'] >= one['source_timestamp']
    sequences = [one['publication_sequence_number'], two['publication_sequence_number']]
    assert sequences == ([None, None] if transport_name == DDS else [1, 2])
    receptions = [one['reception_sequence_number'], two['reception_sequence_number']]
    assert receptions == ([None, None] if transport_name == DDS else [0, 1])


def test_a_callback_of_two_arguments_learns_which_publisher_has_sent_a_message(
    context: Context, make_node: MakeNode, spin: Spin
) -> None:
    listener, came = make_node('listener'), Collector[tuple[str, str]]()
    subscription = listener.create_subscription(
        String, 'chat', lambda message, info: came((message.data, name_of(info))), 10
    )

    def name_of(info: MessageInfo) -> str:
        publisher = info['publisher_gid']
        assert publisher['implementation_identifier'] == get_rmw_implementation_identifier()
        names = {
            bytes(each.endpoint_gid): each.node_name for each in listener.get_publishers_info_by_topic('chat')
        }
        return names[publisher['data']]

    spin(listener)
    for name in ('alice', 'bob'):
        publisher = make_node(name).create_publisher(String, 'chat', 10)
        meet(publisher, subscription, context)
        publisher.publish(String(data=f'I am {name}'))
    assert sorted(came.expect(2)) == [('I am alice', 'alice'), ('I am bob', 'bob')]


def test_a_raw_subscription_gets_the_bytes(context: Context, make_node: MakeNode, spin: Spin) -> None:
    node, came = make_node(), Collector[bytes]()
    publisher = node.create_publisher(String, 'chat', 10)
    meet(publisher, node.create_subscription(String, 'chat', came, 10, raw=True), context)
    spin(node)
    publisher.publish(String(data='text'))
    (raw,) = came.expect()
    sent = serialize_message(String(data='text'))
    assert raw == sent.ljust(len(raw), b'\0')  # DDS fills messages up to a multiple of four
    assert len(raw) - len(sent) in range(4)


def test_bytes_are_published_as_they_are(context: Context, make_node: MakeNode, spin: Spin) -> None:
    node, came = make_node(), Collector[String]()
    publisher = node.create_publisher(String, 'chat', 10)
    meet(publisher, node.create_subscription(String, 'chat', came, 10), context)
    spin(node)
    publisher.publish(serialize_message(String(data='by hand')))
    assert came.expect()[0].data == 'by hand'


@pytest.mark.parametrize('extra', [8, 16, 32])
def test_bytes_behind_a_message_are_ignored(
    context: Context, make_node: MakeNode, spin: Spin, extra: int
) -> None:
    """As the relays and bags of ROS 2 publish them: rmw_serialize reports an estimated size."""
    node, came = make_node(), Collector[String]()
    publisher = node.create_publisher(String, 'chat', 10)
    subscription = node.create_subscription(String, 'chat', came, 10)
    meet(publisher, subscription, context)
    spin(node)
    publisher.publish(serialize_message(String(data='relayed')) + b'\xff' * extra)
    assert came.expect()[0].data == 'relayed'
    assert subscription.rejected == 0


def test_a_full_queue_keeps_the_newest(context: Context, make_node: MakeNode) -> None:
    node, came = make_node(), list[int]()
    all_here = Future[bool]()

    def callback(message: Int32) -> None:
        came.append(message.data)
        if message.data == 9:
            all_here.set_result(True)

    publisher = node.create_publisher(Int32, 'numbers', 10)
    subscription = node.create_subscription(Int32, 'numbers', callback, 3)
    arrived = node.create_subscription(Int32, 'numbers', lambda _: None, 100)
    meet(publisher, subscription, context)
    wait_until(context, lambda: publisher.get_subscription_count() == 2)
    for number in range(10):
        publisher.publish(Int32(data=number))
    with SingleThreadedExecutor(context=context) as executor:
        observer, seen = make_node('observer'), Future[bool]()
        node.destroy_subscription(arrived)
        observer.create_subscription(
            Int32, 'end', lambda _: seen.set_result(True), QoSProfile(depth=1, durability=_LATCHED)
        )
        end = observer.create_publisher(Int32, 'end', QoSProfile(depth=1, durability=_LATCHED))
        end.publish(Int32())
        executor.add_node(observer)
        executor.spin_until_future_complete(seen, 10)
        executor.add_node(node)
        executor.spin_until_future_complete(all_here, 10)
    assert came == [7, 8, 9]


_LATCHED = DurabilityPolicy.TRANSIENT_LOCAL


def test_a_late_subscription_gets_what_a_transient_local_publisher_kept(
    make_node: MakeNode, spin: Spin
) -> None:
    node, came = make_node(), Collector[Int32]()
    profile = QoSProfile(depth=2, durability=_LATCHED)
    publisher = node.create_publisher(Int32, 'kept', profile)
    for number in range(5):
        publisher.publish(Int32(data=number))
    node.create_subscription(Int32, 'kept', came, profile)
    spin(node)
    assert numbers(came.expect(2)) == [3, 4]


def test_a_payload_that_is_no_message_never_reaches_the_callback(
    context: Context, make_node: MakeNode, spin: Spin
) -> None:
    node, came = make_node(), Collector[String]()
    publisher = node.create_publisher(String, 'chat', 10)
    subscription = node.create_subscription(String, 'chat', came, 10)
    meet(publisher, subscription, context)
    spin(node)
    for body in (b'\x05', b'\xff\xff\xff\x7f', b'\x05\x00\x00\x00abc'):
        publisher.publish(b'\x00\x01\x00\x00' + body)
    publisher.publish(String(data='sound'))
    assert [message.data for message in came.expect()] == ['sound']
    assert subscription.rejected == 3


def test_an_exception_comes_out_of_spin_and_the_next_message_is_handled(
    context: Context, make_node: MakeNode, executor: Executor
) -> None:
    node, done = make_node(), Future[str]()

    def callback(message: String) -> None:
        if message.data == 'bad':
            raise ValueError('boom')
        done.set_result(message.data)

    publisher = node.create_publisher(String, 'chat', 10)
    meet(publisher, node.create_subscription(String, 'chat', callback, 10), context)
    executor.add_node(node)
    publisher.publish(String(data='bad'))
    with pytest.raises(ValueError, match='boom'):
        executor.spin_until_future_complete(done, 10)
    publisher.publish(String(data='good'))
    executor.spin_until_future_complete(done, 10)
    assert done.result() == 'good'


def test_a_coroutine_callback_may_sleep(context: Context, make_node: MakeNode, executor: Executor) -> None:
    import asyncio

    node, done = make_node(), Future[str]()

    async def callback(message: String) -> None:
        await asyncio.sleep(0.01)
        done.set_result(message.data)

    publisher = node.create_publisher(String, 'chat', 10)
    meet(publisher, node.create_subscription(String, 'chat', callback, 10), context)
    executor.add_node(node)
    publisher.publish(String(data='slept'))
    executor.spin_until_future_complete(done, 10)
    assert done.result() == 'slept'


def test_a_destroyed_subscription_hears_nothing_more(
    context: Context, make_node: MakeNode, spin: Spin
) -> None:
    node, gone, there = make_node(), Collector[Int32](), Collector[Int32]()
    publisher = node.create_publisher(Int32, 'numbers', 10)
    subscription = node.create_subscription(Int32, 'numbers', gone, 10)
    meet(publisher, subscription, context)
    publisher.publish(Int32(data=1))
    assert node.destroy_subscription(subscription) is True
    assert node.destroy_subscription(subscription) is False
    assert list(node.subscriptions) == []
    with pytest.raises(InvalidHandle):
        subscription.get_publisher_count()
    meet(publisher, node.create_subscription(Int32, 'numbers', there, 10), context)
    spin(node)
    publisher.publish(Int32(data=2))
    assert numbers(there.expect()) == [2]
    assert gone.items == []


def test_a_destroyed_publisher_refuses_to_work(make_node: MakeNode) -> None:
    node = make_node()
    publisher = node.create_publisher(String, 'chat', 1)
    assert publisher.wait_for_all_acked() is True
    assert node.destroy_publisher(publisher) is True
    assert node.destroy_publisher(publisher) is False
    for use in (
        lambda: publisher.publish(String()),
        lambda: publisher.publish(b''),
        publisher.get_subscription_count,
        publisher.wait_for_all_acked,
        publisher.assert_liveliness,
        lambda: publisher.topic_name,
    ):
        with pytest.raises(InvalidHandle, match='destruction was requested'):
            use()


@pytest.mark.parametrize('wrong', [1, None, 'text', String, SetBool.Request()], ids=repr)
def test_only_messages_of_the_type_are_published(make_node: MakeNode, wrong: Any) -> None:
    publisher = make_node().create_publisher(String, 'chat', 1)
    with pytest.raises(TypeError, match=r'^expected std_msgs\.msg\.String, got '):
        publisher.publish(wrong)


def test_a_field_that_cannot_go_on_the_wire_is_named(make_node: MakeNode) -> None:
    node = make_node()
    message = String()
    message.data = 1  # type: ignore[assignment]
    with pytest.raises(EncodeError, match=r'std_msgs/msg/String.*data.*1') as caught:
        node.create_publisher(String, 'chat', 1).publish(message)
    assert isinstance(caught.value, TypeError)
    with pytest.raises(EncodeError, match=r'Int32.*data.*2147483648') as too_big:
        node.create_publisher(Int32, 'number', 1).publish(Int32(data=2**31))
    assert isinstance(too_big.value, ValueError)


def test_publishing_after_shutdown_says_so(context: Context, make_node: MakeNode) -> None:
    publisher = make_node().create_publisher(String, 'chat', 1)
    context.shutdown()
    with pytest.raises(RuntimeError, match='shut'):
        publisher.publish(String())


def test_two_domains_do_not_hear_each_other(
    isolated: dict[str, str], context: Context, make_node: MakeNode, spin: Spin
) -> None:
    from helpers.isolation import fresh_domain
    from rclpy.node import Node

    other = Context()
    other.init(args=[], domain_id=fresh_domain())
    try:
        here, there = make_node(), Node('elsewhere', context=other)
        heard, own = Collector[Int32](), Collector[Int32]()
        publisher = here.create_publisher(Int32, 'numbers', 10)
        meet(publisher, here.create_subscription(Int32, 'numbers', own, 10), context)
        deaf = there.create_subscription(Int32, 'numbers', heard, 10)
        spin(here)
        with SingleThreadedExecutor(context=other) as executor:
            executor.add_node(there)
            publisher.publish(Int32(data=5))
            own.expect()
            later = there.create_publisher(Int32, 'numbers', 10)
            meet(later, deaf, other)
            later.publish(Int32(data=6))
            while not heard.items:
                executor.spin_once()
        assert [message.data for message in heard.items] == [6]
        assert here.get_node_names() == ['node']
        assert there.get_node_names() == ['elsewhere']
    finally:
        other.shutdown()


def test_publishers_and_subscriptions_name_the_class_of_their_messages(make_node: MakeNode) -> None:
    node = make_node()
    assert node.create_publisher(String, 'chat', 10).msg_type is String
    assert node.create_subscription(String, 'chat', lambda _: None, 10).msg_type is String
