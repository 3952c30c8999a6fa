"""The graph as nodes see it."""

from __future__ import annotations

import threading
from typing import NamedTuple

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, wait_until
from helpers.standing import own
from rclpy.action import (
    ActionClient,
    ActionServer,
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from rclpy.context import Context
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointTypeEnum
from std_msgs.msg import String

from goalwire.errors import RCLError

pytestmark = pytest.mark.also_on_dds

ADD = ['example_interfaces/srv/AddTwoInts']
CHAT = ['std_msgs/msg/String']
FIBONACCI = ['example_interfaces/action/Fibonacci']
BEST_EFFORT = QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT)


class Two(NamedTuple):
    a: Node
    b: Node


@pytest.fixture
def two(context: Context, make_node: MakeNode) -> Two:
    """/gn/ga publishes chat and serves add; /gb subscribes and calls."""
    a, b = make_node('ga', namespace='gn'), make_node('gb')
    a.create_publisher(String, 'chat', BEST_EFFORT)
    a.create_service(AddTwoInts, 'add', lambda request, response: response)
    b.create_subscription(String, '/gn/chat', lambda _: None, 5)
    b.create_client(AddTwoInts, '/gn/add')
    for node in (a, b):
        wait_until(
            context,
            lambda node=node: (
                (  # type: ignore[misc]
                    node.count_publishers('/gn/chat'),
                    node.count_subscribers('/gn/chat'),
                    node.count_services('/gn/add'),
                    node.count_clients('/gn/add'),
                )
                == (1, 1, 1, 1)
            ),
        )
    return Two(a, b)


def test_nodes(two: Two) -> None:
    for node in two:
        assert sorted(node.get_node_names()) == ['ga', 'gb']
        assert sorted(node.get_node_names_and_namespaces()) == [('ga', '/gn'), ('gb', '/')]
        assert sorted(node.get_node_names_and_namespaces_with_enclaves()) == [
            ('ga', '/gn', '/'),
            ('gb', '/', '/'),
        ]
        assert sorted(node.get_fully_qualified_node_names()) == ['/gb', '/gn/ga']


def test_names_and_types(two: Two) -> None:
    for node in two:
        assert own(node.get_topic_names_and_types()) == [('/gn/chat', CHAT)]
        assert own(node.get_service_names_and_types()) == [('/gn/add', ADD)]
        assert own(node.get_publisher_names_and_types_by_node('ga', '/gn')) == [('/gn/chat', CHAT)]
        assert node.get_subscriber_names_and_types_by_node('gb', '/') == [('/gn/chat', CHAT)]
        assert own(node.get_service_names_and_types_by_node('ga', '/gn')) == [('/gn/add', ADD)]
        assert node.get_client_names_and_types_by_node('gb', '/') == [('/gn/add', ADD)]
        assert own(node.get_publisher_names_and_types_by_node('gb', '/')) == []


def test_counts_expand_names(two: Two) -> None:
    assert (two.a.count_publishers('chat'), two.b.count_publishers('chat')) == (1, 0)
    assert (two.a.count_services('add'), two.a.count_clients('add')) == (1, 1)
    with pytest.raises(ValueError, match=r"^topic name 'a b' is invalid: topic name must not contain"):
        two.a.count_publishers('a b')
    with pytest.raises(ValueError, match=r"^topic name '' is invalid: topic name must not be empty string"):
        two.a.count_services('')


def test_questions_about_nobody(two: Two) -> None:
    for ask, what in (
        (two.a.get_publisher_names_and_types_by_node, 'publisher'),
        (two.a.get_subscriber_names_and_types_by_node, 'subscriber'),
        (two.a.get_service_names_and_types_by_node, 'service'),
        (two.a.get_client_names_and_types_by_node, 'client'),
    ):
        with pytest.raises(NodeNameNonExistentError, match=f'^cannot get {what} names and types for'):
            ask('nonode', '/')
        with pytest.raises(RCLError, match=f'^failed to get {what} names and types: node name must not'):
            ask('bad name', '/')
        with pytest.raises(RCLError, match='namespace must be absolute'):
            ask('ga', 'bad')


def test_endpoints_of_a_topic(two: Two) -> None:
    (info,) = two.b.get_publishers_info_by_topic('/gn/chat')
    assert (info.node_name, info.node_namespace, info.topic_type) == ('ga', '/gn', 'std_msgs/msg/String')
    assert info.endpoint_type is TopicEndpointTypeEnum.PUBLISHER
    assert str(info.topic_type_hash) == (
        'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
    )
    assert str(info.qos_profile) == (
        'QoSProfile(history=1, depth=3, reliability=2, durability=2, lifespan=Infinite, deadline=Infinite, '
        'liveliness=1, liveliness_lease_duration=Infinite, avoid_ros_namespace_conventions=False)'
    )
    assert len(info.endpoint_gid) == 16
    assert [info] == two.a.get_publishers_info_by_topic('chat')
    (subscription,) = two.a.get_subscriptions_info_by_topic('chat')
    assert subscription.endpoint_type is TopicEndpointTypeEnum.SUBSCRIPTION
    assert subscription != info
    assert two.a.get_publishers_info_by_topic('/nosuch') == []
    assert len(two.b.get_publishers_info_by_topic('/gn/chat', no_mangle=True)) == 1
    with pytest.raises(ValueError, match="topic name 'a b' is invalid"):
        two.a.get_publishers_info_by_topic('a b')


def test_waiting_for_a_node(two: Two, make_node: MakeNode) -> None:
    assert two.a.wait_for_node('/gb', 1.0) is True
    assert two.a.wait_for_node('gb', 1.0) is True
    assert two.a.wait_for_node('/nonode', 0.05) is False
    assert (two.a.wait_for_node('/gb', 0), two.a.wait_for_node('/nonode', -1)) == (True, False)
    with pytest.raises(TypeError, match="must be a number of seconds, got 'x'"):
        two.a.wait_for_node('/gb', 'x')  # type: ignore[arg-type]
    came: Collector[bool] = Collector()
    thread = threading.Thread(target=lambda: came(two.a.wait_for_node('/late', PATIENCE)))
    thread.start()
    make_node('late')
    assert came.expect() == [True]
    thread.join()


def test_actions(context: Context, make_node: MakeNode) -> None:
    server, node = make_node('server', namespace='s'), make_node('client')
    ActionServer(server, Fibonacci, 'fib', lambda _: Fibonacci.Result())
    client = ActionClient(node, Fibonacci, '/s/fib')
    assert client.wait_for_server(PATIENCE)
    wait_until(context, lambda: server.count_subscribers('fib/_action/status') == 1)
    for asking in (server, node):
        assert get_action_names_and_types(asking) == [('/s/fib', FIBONACCI)]
        assert get_action_server_names_and_types_by_node(asking, 'server', '/s') == [('/s/fib', FIBONACCI)]
        assert get_action_client_names_and_types_by_node(asking, 'client', '/') == [('/s/fib', FIBONACCI)]
        assert get_action_client_names_and_types_by_node(asking, 'server', '/s') == []
        with pytest.raises(NodeNameNonExistentError, match='nonode'):
            get_action_server_names_and_types_by_node(asking, 'nonode', '/')
        with pytest.raises(NodeNameNonExistentError, match='nonode'):
            get_action_client_names_and_types_by_node(asking, 'nonode', '/')


def test_a_server_that_goes_leaves_the_graph(context: Context, make_node: MakeNode) -> None:
    server, node = make_node('server'), make_node()
    action_server = ActionServer(server, Fibonacci, 'fib', lambda _: Fibonacci.Result())
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    action_server.destroy()
    wait_until(context, lambda: not client.server_is_ready())
