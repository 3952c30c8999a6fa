"""Programs keep things of their own on rclpy's objects, and hold them weakly, as they can in ROS 2."""

from __future__ import annotations

import weakref
from collections.abc import Callable

import pytest
from action_msgs.msg import GoalInfo
from example_interfaces.action import Fibonacci
from helpers.spinning import MakeNode
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.task import Future, Task
from rclpy.time import Time
from std_msgs.msg import String
from std_srvs.srv import Trigger


def _goal(node: Node) -> object:
    server = ActionServer(node, Fibonacci, 'fibonacci', lambda _goal: Fibonacci.Result())
    return ServerGoalHandle(server, GoalInfo(), Fibonacci.Goal())


MAKERS: dict[str, Callable[[Node], object]] = {
    'node': lambda node: node,
    'publisher': lambda node: node.create_publisher(String, 'x', 1),
    'subscription': lambda node: node.create_subscription(String, 'x', print, 1),
    'client': lambda node: node.create_client(Trigger, 'x'),
    'service': lambda node: node.create_service(Trigger, 'x', lambda _request, response: response),
    'timer': lambda node: node.create_timer(9.0, print),
    'guard condition': lambda node: node.create_guard_condition(print),
    'future': lambda _node: Future[int](),
    'task': lambda _node: Task(print),
    'duration': lambda _node: Duration(seconds=1),
    'time': lambda _node: Time(seconds=1),
    'clock': lambda _node: Clock(),
    'goal': _goal,
}


@pytest.mark.parametrize('what', MAKERS)
def test_an_object_takes_an_attribute_and_a_weak_reference(what: str, make_node: MakeNode) -> None:
    thing = MAKERS[what](make_node())
    thing.note = 'mine'  # type: ignore[attr-defined]
    assert thing.note == 'mine'  # type: ignore[attr-defined]
    assert weakref.ref(thing)() is thing
