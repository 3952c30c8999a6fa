"""The QoS that endpoints get, as the graph shows it."""

from __future__ import annotations

import pytest
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, wait_until
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_best_available,
    qos_profile_services_default,
    qos_profile_unknown,
)
from std_msgs.msg import String

from goalwire.errors import RCLError

pytestmark = pytest.mark.also_on_dds

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def nothing(*_: object) -> None:
    """Take what comes."""


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node('n')


def of_subscription(node: Node, topic: str, *, number: int = 1) -> QoSProfile:
    wait_until(node.context, lambda: node.count_subscribers(topic) == number)
    return node.get_subscriptions_info_by_topic(topic)[-1].qos_profile


def test_a_profile_with_unknown_policies_is_refused_by_every_kind_of_endpoint(node: Node) -> None:
    for make in (
        lambda: node.create_publisher(String, 'chat', qos_profile_unknown),
        lambda: node.create_subscription(String, 'chat', nothing, qos_profile_unknown),
        lambda: node.create_client(AddTwoInts, 'chat', qos_profile=qos_profile_unknown),
        lambda: node.create_service(
            AddTwoInts, 'chat', lambda _, response: response, qos_profile=qos_profile_unknown
        ),
    ):
        with pytest.raises(RCLError, match=r"^Failed to create \w+: the QoS of '/chat' has history UNKNOWN"):
            make()


def test_best_available_asks_for_what_the_publishers_there_offer(
    node: Node, make_node: MakeNode, spin: Spin, context: Context
) -> None:
    talker = make_node('talker')
    publisher = talker.create_publisher(String, 'map', LATCHED)
    publisher.publish(String(data='early'))
    wait_until(context, lambda: node.count_publishers('map') == 1)
    came: Collector[String] = Collector()
    subscription = node.create_subscription(String, 'map', came, qos_profile_best_available)
    spin(node, talker)
    assert came.expect(1) == [String(data='early')]
    assert of_subscription(node, 'map').durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert subscription.qos_profile is qos_profile_best_available


def test_best_available_without_publishers_is_an_ordinary_subscription(node: Node) -> None:
    node.create_subscription(String, 'map', nothing, qos_profile_best_available)
    shown = of_subscription(node, 'map')
    assert (shown.reliability, shown.durability, shown.liveliness) == (
        ReliabilityPolicy.RELIABLE,
        DurabilityPolicy.VOLATILE,
        LivelinessPolicy.AUTOMATIC,
    )


def test_best_available_offers_the_most_there_is(node: Node, context: Context) -> None:
    node.create_publisher(String, 'map', qos_profile_best_available)
    wait_until(context, lambda: node.count_publishers('map') == 1)
    (shown,) = node.get_publishers_info_by_topic('map')
    assert (shown.qos_profile.reliability, shown.qos_profile.durability) == (
        ReliabilityPolicy.RELIABLE,
        DurabilityPolicy.TRANSIENT_LOCAL,
    )


def test_services_of_best_available_answer(node: Node, make_node: MakeNode, spin: Spin) -> None:
    other = make_node('other')
    service = node.create_service(
        AddTwoInts, 'add', lambda _, response: response, qos_profile=qos_profile_best_available
    )
    client = other.create_client(AddTwoInts, 'add', qos_profile=qos_profile_best_available)
    spin(node, other)
    assert client.wait_for_service(10)
    assert client.call(AddTwoInts.Request(), timeout_sec=PATIENCE) == AddTwoInts.Response()
    assert service.qos_profile == qos_profile_best_available != qos_profile_services_default
