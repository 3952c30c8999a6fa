"""Events of publishers and subscriptions, as rclpy's programs see them."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, Spinner, wait_until
from helpers.wires import DDS
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.event_handler import (
    EventHandler,
    IncompatibleTypeInfo,
    PublisherEventCallbacks,
    QoSEventHandler,
    QoSMessageLostInfo,
    QoSOfferedIncompatibleQoSInfo,
    QoSPublisherEventType,
    QoSPublisherMatchedInfo,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionEventType,
    QoSSubscriptionMatchedInfo,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)
from rclpy.exceptions import InvalidHandle
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.waitable import Waitable
from std_msgs.msg import Int32, String

from goalwire.errors import RCLError
from goalwire.logging.dispatch import add_sink
from goalwire.logging.record import LogRecord
from goalwire.transport.contract import Sample
from goalwire.transport.faults import Faults

pytestmark = pytest.mark.also_on_dds

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1)
MATCHED = QoSPublisherEventType.RCL_PUBLISHER_MATCHED


def nothing(_: object) -> None:
    """Take a message."""


@pytest.fixture
def logged() -> Iterator[Collector[str]]:
    """Each line that a node logs, as 'logger: message'."""
    lines: Collector[str] = Collector()

    def take(record: LogRecord) -> None:
        if record.name in {'n', 'o', 'goalwire'}:
            lines(f'{record.name}: {record.message}')

    with add_sink(take):
        yield lines


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node('n')


@pytest.fixture
def other(make_node: MakeNode) -> Node:
    return make_node('o')


def test_matched_events_count_who_is_there_and_who_was(node: Node, other: Node, spin: Spin) -> None:
    publishers: Collector[QoSPublisherMatchedInfo] = Collector()
    subscriptions: Collector[QoSSubscriptionMatchedInfo] = Collector()
    spin(node, other)
    node.create_publisher(String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=publishers))
    subscription = other.create_subscription(
        String, 'chat', nothing, 1, event_callbacks=SubscriptionEventCallbacks(matched=subscriptions)
    )
    assert publishers.expect(1) == [QoSPublisherMatchedInfo(1, 1, 1, 1)]
    assert subscriptions.expect(1) == [QoSSubscriptionMatchedInfo(1, 1, 1, 1)]
    other.destroy_subscription(subscription)
    assert publishers.expect(2)[1] == QoSPublisherMatchedInfo(
        total_count=1, total_count_change=0, current_count=0, current_count_change=-1
    )
    other.create_subscription(String, 'chat', nothing, 1)
    assert publishers.expect(3)[2] == QoSPublisherMatchedInfo(2, 1, 1, 1)


def test_a_matched_callback_finds_the_match_in_its_endpoints_count(
    node: Node, other: Node, spin: Spin
) -> None:
    subscribers: Collector[tuple[int, int]] = Collector()
    publishers: Collector[tuple[int, int]] = Collector()

    def met_subscriber(info: QoSPublisherMatchedInfo) -> None:
        subscribers((info.current_count, publisher.get_subscription_count()))

    def met_publisher(info: QoSSubscriptionMatchedInfo) -> None:
        publishers((info.current_count, subscription.get_publisher_count()))

    publisher = node.create_publisher(
        String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=met_subscriber)
    )
    subscription = other.create_subscription(
        String, 'chat', nothing, 1, event_callbacks=SubscriptionEventCallbacks(matched=met_publisher)
    )
    spin(node, other)
    assert (publishers.expect(1), subscribers.expect(1)) == ([(1, 1)], [(1, 1)])
    other.destroy_subscription(subscription)
    assert subscribers.expect(2)[1] == (0, 0)


def test_a_partition_ends_a_match_in_event_and_count(isolated: dict[str, str]) -> None:
    counts: Collector[tuple[int, int]] = Collector()

    def matched(info: QoSPublisherMatchedInfo) -> None:
        counts((info.current_count, publisher.get_subscription_count()))

    assert isolated
    near, far = Context(), Context()
    with Faults() as faults, rclpy.init(context=near), rclpy.init(context=far):
        node, other = Node('near', context=near), Node('far', context=far)
        publisher = node.create_publisher(
            String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=matched)
        )
        with SingleThreadedExecutor(context=near) as executor, Spinner(executor, node):
            other.create_subscription(String, 'chat', nothing, 1)
            assert counts.expect(1) == [(1, 1)]
            faults.partition('near', 'far', lease=0.0)
            assert counts.expect(2)[1] == (0, 0)


def test_events_that_nobody_spun_for_are_one_call(node: Node, other: Node, spin: Spin) -> None:
    matched: Collector[QoSPublisherMatchedInfo] = Collector()
    publisher = node.create_publisher(
        String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=matched)
    )
    changes: Collector[None] = Collector()
    for handler in publisher.event_handlers:
        if handler.event_type is QoSPublisherEventType.RCL_PUBLISHER_MATCHED:
            handler._reader.watchers = (lambda: changes(None),)
    stays = other.create_subscription(String, 'chat', nothing, 1)
    changes.expect(1)
    goes = other.create_subscription(String, 'chat', nothing, 1)
    changes.expect(2)
    other.destroy_subscription(goes)
    changes.expect(3)
    spin(node)
    assert matched.expect(1) == [QoSPublisherMatchedInfo(2, 2, 1, 1)]
    assert not stays.destroyed


def test_incompatible_qos_is_told_on_both_sides_with_the_policy(node: Node, other: Node, spin: Spin) -> None:
    offered: Collector[QoSOfferedIncompatibleQoSInfo] = Collector()
    requested: Collector[QoSRequestedIncompatibleQoSInfo] = Collector()
    node.create_publisher(
        String, 'chat', BEST_EFFORT, event_callbacks=PublisherEventCallbacks(incompatible_qos=offered)
    )
    other.create_subscription(
        String,
        'chat',
        nothing,
        RELIABLE,
        event_callbacks=SubscriptionEventCallbacks(incompatible_qos=requested),
    )
    spin(node, other)
    for (info,) in (offered.expect(1), requested.expect(1)):
        assert (info.total_count, info.total_count_change) == (1, 1)
        assert QoSPolicyKind(info.last_policy_kind) is QoSPolicyKind.RELIABILITY
        assert info.last_policy_kind.name == 'RMW_QOS_POLICY_RELIABILITY'


def test_by_default_incompatible_qos_is_logged_on_both_sides_in_ros_2s_words(
    node: Node, other: Node, spin: Spin, logged: Collector[str], transport_name: str
) -> None:
    node.create_publisher(String, 'chat', BEST_EFFORT)
    lasting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    other.create_subscription(String, 'chat', nothing, lasting)
    spin(node, other)
    lines = logged.expect(2)
    limit = 'N' if transport_name == DDS else 'With DDS, as on most robots, n'
    remedy = 'Last incompatible policy: RELIABILITY; write reliability=ReliabilityPolicy.RELIABLE in the '
    for begin in (
        f"n: New subscription discovered on topic 'chat', requesting incompatible QoS. {limit}o messages ",
        f"o: New publisher discovered on topic 'chat', offering incompatible QoS. {limit}o messages ",
    ):
        [line] = [line for line in lines if line.startswith(begin)]
        assert remedy in line
        assert re.search(r'\(.*test_event_handler\.py:\d+\)$', line)


@pytest.mark.differs_on(DDS, 'endpoints with incompatible QoS exchange nothing')
def test_where_qos_prevents_nothing_messages_and_matches_come_all_the_same(
    node: Node, other: Node, spin: Spin
) -> None:
    came: Collector[String] = Collector()
    matched: Collector[QoSPublisherMatchedInfo] = Collector()
    publisher = node.create_publisher(
        String, 'chat', BEST_EFFORT, event_callbacks=PublisherEventCallbacks(matched=matched)
    )
    subscription = other.create_subscription(String, 'chat', came, RELIABLE)
    spin(node, other)
    assert matched.expect(1)[0].current_count == 1
    publisher.publish(String(data='x'))
    assert came.expect(1) == [String(data='x')]
    counts = (publisher.get_subscription_count(), subscription.get_publisher_count())
    assert counts == (1, 1)


def test_counts_of_matches_ask_the_qos_where_the_wire_does(
    node: Node, other: Node, context: Context, transport_name: str
) -> None:
    publisher = node.create_publisher(String, 'chat', BEST_EFFORT)
    matching = other.create_subscription(String, 'chat', nothing, BEST_EFFORT)
    asking = other.create_subscription(String, 'chat', nothing, RELIABLE)
    wait_until(context, lambda: matching.get_publisher_count() == 1)
    wait_until(context, lambda: node.count_subscribers('chat') == 2)
    separated = transport_name == DDS
    wait_until(context, lambda: publisher.get_subscription_count() == (1 if separated else 2))
    assert asking.get_publisher_count() == (0 if separated else 1)


def test_another_type_of_the_topic_is_told_and_is_no_match(node: Node, other: Node, spin: Spin) -> None:
    types: Collector[IncompatibleTypeInfo] = Collector()
    matched: Collector[QoSPublisherMatchedInfo] = Collector()
    callbacks = PublisherEventCallbacks(incompatible_type=types, matched=matched)
    publisher = node.create_publisher(String, 'chat', 1, event_callbacks=callbacks)
    other.create_subscription(Int32, 'chat', nothing, 1)
    other.create_subscription(String, 'chat', nothing, 1)
    spin(node)
    assert types.expect(1) == [IncompatibleTypeInfo(1, 1)]
    assert matched.expect(1) == [QoSPublisherMatchedInfo(1, 1, 1, 1)]
    assert publisher.get_subscription_count() == 1


def test_another_type_is_logged_once_with_both_types_and_nodes(
    node: Node, other: Node, spin: Spin, logged: Collector[str]
) -> None:
    node.create_publisher(String, 'chat', 1)
    other.create_subscription(Int32, 'chat', nothing, 1)
    spin(node, other)
    text = "Incompatible type on topic '/chat', no messages will be sent to it: "
    (line,) = logged.expect(1)
    assert line.startswith(f'goalwire: {text}')
    for part in (
        "publisher in node '/n' has the type std_msgs/msg/String",
        "subscription in node '/o'",
        'Int32',
    ):
        assert part in line


def test_without_defaults_nothing_is_logged(
    node: Node, other: Node, spin: Spin, logged: Collector[str], context: Context
) -> None:
    quiet = PublisherEventCallbacks(use_default_callbacks=False)
    publisher = node.create_publisher(String, 'chat', BEST_EFFORT, event_callbacks=quiet)
    other.create_subscription(String, 'chat', nothing, RELIABLE)
    wait_until(context, lambda: node.count_subscribers('chat') == 1)
    spin(node, other)
    assert publisher.event_handlers == []
    assert [line.partition(':')[0] for line in logged.expect(1)] == ['o']


@pytest.mark.differs_on(DDS, 'messages are not numbered')
def test_lost_messages_are_counted_by_their_numbers(node: Node, spin: Spin) -> None:
    lost: Collector[QoSMessageLostInfo] = Collector()
    subscription = node.create_subscription(
        String, 'chat', nothing, 10, event_callbacks=SubscriptionEventCallbacks(message_lost=lost)
    )
    for number in (4, 5, 8, 6, 9, 11):
        subscription.event_queue.deliver(Sample(b'', number, 0, 0, b'publisher'))
    spin(node)
    assert lost.expect(1) == [QoSMessageLostInfo(total_count=3, total_count_change=3)]


@pytest.mark.differs_on(DDS, 'deadlines and liveliness are watched')
@pytest.mark.parametrize('name', ['deadline', 'liveliness'])
def test_what_the_wire_cannot_tell_is_refused_and_leaves_nothing_behind(
    node: Node, name: str, transport_name: str, context: Context
) -> None:
    callbacks: Any = {name: nothing}
    before = list(node.waitables)
    refused = f'^Failed to initialize event: .*{name.upper()}.* is not supported by {transport_name}'
    with pytest.raises(UnsupportedEventTypeError, match=refused) as raised:
        node.create_publisher(String, 'chat', 1, event_callbacks=PublisherEventCallbacks(**callbacks))
    assert isinstance(raised.value, RCLError)
    with pytest.raises(UnsupportedEventTypeError, match=refused):
        node.create_subscription(
            String, 'chat', nothing, 1, event_callbacks=SubscriptionEventCallbacks(**callbacks)
        )
    assert (list(node.waitables), '/chat' in {each.full_name for each in node.publishers}) == (before, False)
    wait_until(context, lambda: node.count_publishers('chat') == node.count_subscribers('chat') == 0)


def test_handlers_are_listed_in_rclpys_order_and_among_the_waitables(node: Node) -> None:
    before = len(list(node.waitables))
    everything = PublisherEventCallbacks(incompatible_qos=nothing, incompatible_type=nothing, matched=nothing)
    publisher = node.create_publisher(String, 'chat', 1, event_callbacks=everything)
    assert [handler.event_type.name for handler in publisher.event_handlers] == [
        'RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS',
        'RCL_PUBLISHER_INCOMPATIBLE_TYPE',
        'RCL_PUBLISHER_MATCHED',
    ]
    subscription = node.create_subscription(
        String,
        'chat',
        nothing,
        1,
        event_callbacks=SubscriptionEventCallbacks(message_lost=nothing, matched=nothing),
    )
    assert [handler.event_type.name for handler in subscription.event_handlers] == [
        'RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS',
        'RCL_SUBSCRIPTION_MESSAGE_LOST',
        'RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE',
        'RCL_SUBSCRIPTION_MATCHED',
    ]
    handlers = [*publisher.event_handlers, *subscription.event_handlers]
    assert list(node.waitables)[before:] == handlers
    assert all(isinstance(handler, Waitable) for handler in handlers)
    node.destroy_publisher(publisher)
    node.destroy_subscription(subscription)
    assert len(list(node.waitables)) == before


def test_a_handlers_callback_runs_under_its_group(
    node: Node, other: Node, spin: Spin, context: Context
) -> None:
    group = MutuallyExclusiveCallbackGroup()
    seen: Collector[object] = Collector()
    publisher = node.create_publisher(
        String,
        'chat',
        1,
        callback_group=group,
        event_callbacks=PublisherEventCallbacks(matched=lambda _: seen(group.active_entity)),
    )
    assert all(group.has_entity(handler) for handler in publisher.event_handlers)
    other.create_subscription(String, 'chat', nothing, 1)
    wait_until(context, lambda: publisher.get_subscription_count() == 1)
    blocker = object()
    assert group.beginning_execution(blocker)
    spin(node, threads=2)
    spin(other)
    assert seen.items == []
    group.ending_execution(blocker)
    assert seen.expect(1)[0] is not None


def test_a_callback_may_be_a_coroutine_function(node: Node, other: Node, spin: Spin) -> None:
    came: Collector[object] = Collector()

    async def later(info: object) -> None:
        await asyncio.sleep(0)
        came(info)

    node.create_publisher(String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=later))
    other.create_subscription(String, 'chat', nothing, 1)
    spin(node)
    assert came.expect(1) == [QoSPublisherMatchedInfo(1, 1, 1, 1)]


def test_a_handler_made_late_is_told_of_what_has_happened(node: Node, other: Node, spin: Spin) -> None:
    publisher = node.create_publisher(String, 'chat', BEST_EFFORT)
    other.create_subscription(String, 'chat', nothing, RELIABLE)
    other.create_subscription(String, 'chat', nothing, RELIABLE)
    came: Collector[QoSOfferedIncompatibleQoSInfo] = Collector()
    EventHandler(
        callback_group=ReentrantCallbackGroup(),
        callback=came,
        event_type=QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        parent_impl=publisher.handle,
    )
    spin(node)
    assert came.wait_for(lambda items: bool(items) and items[-1].total_count == 2)
    assert sum(info.total_count_change for info in came.items) == 2


def test_a_program_may_wait_for_events_itself(node: Node, other: Node, context: Context) -> None:
    publisher = node.create_publisher(String, 'chat', 1)
    handler = EventHandler(
        callback_group=node.default_callback_group,
        callback=nothing,
        event_type=MATCHED,
        parent_impl=publisher.handle,
    )
    came: Collector[object] = Collector()

    class Watcher(Waitable[Any]):
        def is_ready(self, wait_set: Any) -> bool:
            return handler.is_ready(wait_set)

        def take_data(self) -> Any:
            return handler.take_data()

        async def execute(self, taken_data: Any) -> None:
            came(taken_data)

        def get_num_entities(self) -> Any:
            return handler.get_num_entities()

        def add_to_wait_set(self, wait_set: Any) -> None:
            handler.add_to_wait_set(wait_set)

    watching = Node('w', context=context)
    watching.add_waitable(Watcher(ReentrantCallbackGroup()))
    other.create_subscription(String, 'chat', nothing, 1)
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(watching)
        while not came.items:
            executor.spin_once(timeout_sec=PATIENCE)
    assert came.items == [QoSPublisherMatchedInfo(1, 1, 1, 1)]
    assert handler.get_num_entities().num_events == 1
    assert handler.take_data() is None
    watching.destroy_node()


def test_a_destroyed_handler_calls_back_no_more(node: Node, other: Node, spin: Spin) -> None:
    matched: Collector[object] = Collector()
    still: Collector[object] = Collector()
    publisher = node.create_publisher(
        String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=matched)
    )
    handler = publisher.event_handlers[-1]
    handler.destroy()
    handler.destroy()
    EventHandler(
        callback_group=node.default_callback_group,
        callback=still,
        event_type=MATCHED,
        parent_impl=publisher.handle,
    )
    other.create_subscription(String, 'chat', nothing, 1)
    spin(node)
    still.expect(1)
    assert matched.items == []
    with pytest.raises(InvalidHandle):
        handler.take_data()
    with pytest.raises(InvalidHandle):
        handler.__enter__()


def test_a_destroyed_publisher_has_no_events(node: Node) -> None:
    publisher = node.create_publisher(String, 'chat', 1)
    node.destroy_publisher(publisher)
    with pytest.raises(InvalidHandle):
        publisher.event_handlers[0].take_data()
    with pytest.raises(InvalidHandle):
        EventHandler(
            callback_group=node.default_callback_group,
            callback=nothing,
            event_type=MATCHED,
            parent_impl=publisher.handle,
        )


def test_an_event_of_the_other_kind_of_endpoint_is_refused(node: Node) -> None:
    publisher = node.create_publisher(String, 'chat', 1)
    for wrong in (QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED, 'x'):
        with pytest.raises(TypeError, match=r'a publisher has no event .*RCL_PUBLISHER_MATCHED'):
            EventHandler(
                callback_group=node.default_callback_group,
                callback=nothing,
                event_type=wrong,  # type: ignore[arg-type]
                parent_impl=publisher.handle,
            )


def test_a_callback_may_be_replaced(node: Node, other: Node, spin: Spin) -> None:
    first: Collector[object] = Collector()
    second: Collector[object] = Collector()
    publisher = node.create_publisher(
        String, 'chat', 1, event_callbacks=PublisherEventCallbacks(matched=first)
    )
    publisher.event_handlers[-1].callback = second
    assert publisher.event_handlers[-1].callback is second
    other.create_subscription(String, 'chat', nothing, 1)
    spin(node)
    second.expect(1)
    assert first.items == []


def test_the_old_name_works_and_warns(node: Node) -> None:
    publisher = node.create_publisher(String, 'chat', 1)
    with pytest.warns(DeprecationWarning, match='use EventHandler instead'):
        handler = QoSEventHandler(
            callback_group=node.default_callback_group,
            callback=nothing,
            event_type=MATCHED,
            parent_impl=publisher.handle,
        )
    assert isinstance(handler, EventHandler)
    with pytest.warns(DeprecationWarning, match='use EventHandler instead'):
        type('Own', (QoSEventHandler,), {})
