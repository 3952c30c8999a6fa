"""The counts that rclpy's entities keep here, in addition to what rclpy knows."""

from __future__ import annotations

from helpers.actions import Arena, succeed
from helpers.collector import Collector
from helpers.spinning import MakeNode, Spin, wait_until
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool


def answer(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    return response


def test_every_entity_of_a_node_counts(make_node: MakeNode, spin: Spin) -> None:
    node: Node = make_node('node')
    publisher = node.create_publisher(String, 'topic', 10)
    heard: Collector[String] = Collector()
    ticks: Collector[str] = Collector()
    subscription = node.create_subscription(String, 'topic', heard, 10)
    service = node.create_service(SetBool, 'lamp', answer)
    client = node.create_client(SetBool, 'lamp')
    timer = node.create_timer(0.001, lambda: ticks('tick'))
    wait_until(node.context, lambda: publisher.get_subscription_count() == 1)
    spin(node)
    assert client.wait_for_service(5.0)
    client.call(SetBool.Request())
    publisher.publish(String())
    heard.expect(1)
    ticks.expect(2)
    counted = node.handle.statistics()
    assert publisher.statistics() in counted.publishers
    assert subscription.statistics().taken == 1
    assert timer.statistics().calls >= 2
    assert subscription.statistics() in counted.subscriptions
    assert (client.statistics().sent, client.statistics().answered) == (1, 1)
    assert service.statistics().answered == 1
    assert service.statistics() in counted.services
    assert client.statistics() in counted.clients
    assert timer.statistics().lateness.p50 < 5.0
    assert [each.period for each in counted.timers] == [0.001]


def test_actions_count(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    handle = arena.accept(1)
    assert arena.result(handle) == ('SUCCEEDED', [1])
    sent, served = arena.client.statistics(), arena.server.statistics()
    assert (sent.name, sent.goals.succeeded, sent.duration.count) == ('/fib', 1, 1)
    assert (served.name, served.goals.succeeded, served.execution.count) == ('/fib', 1, 1)
    assert served in arena.server_node.handle.statistics().action_servers
    assert sent in arena.client_node.handle.statistics().action_clients
