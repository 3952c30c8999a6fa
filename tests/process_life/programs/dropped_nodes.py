"""Nodes that a program drops without destroying them leave the graph: bare ones, and ones in cycles."""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import TypeAlias

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from goalwire.execution.waiters import Waiter

Goal: TypeAlias = ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]

PATIENCE_NS = 20_000_000_000


class Robot(Node):
    """Has one of each, with callbacks of its own."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.said = self.create_publisher(String, 'said', 10)
        self.create_subscription(String, 'said', self.hear, 10)
        self.create_service(Trigger, 'trigger', self.serve)
        self.triggers = self.create_client(Trigger, 'trigger')
        self.create_timer(3600.0, self.tick)
        self.server = ActionServer(self, Fibonacci, 'count', self.count)
        self.counts = ActionClient(self, Fibonacci, 'count')

    def hear(self, message: String) -> None: ...

    def tick(self) -> None: ...

    def serve(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return response

    def count(self, _handle: Goal) -> Fibonacci.Result:
        return Fibonacci.Result()


def await_names(*names: str) -> None:
    """Wait until the graph has these nodes and no others."""
    waiter = Waiter()
    changes = watcher.context.graph.on_change(waiter.wake)
    while sorted(watcher.get_node_names()) != sorted(names):
        if not waiter.wait(PATIENCE_NS):
            raise SystemExit(f'{watcher.get_node_names()} are there, and not {names}')
    changes.close()


def drop(make: Callable[[], object]) -> None:
    make()
    gc.collect()
    await_names('watcher')


def make_in_executor() -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(Robot('in_executor'))
    executor.spin_once(timeout_sec=0)


rclpy.init()
watcher = rclpy.create_node('watcher', enable_rosout=False)
drop(lambda: rclpy.create_node('bare'))
drop(lambda: Robot('robot'))
drop(lambda: rclpy.spin_once(Robot('spun'), timeout_sec=0))
drop(make_in_executor)
print('all have left')

executor = SingleThreadedExecutor()
executor.add_node(Robot('kept'))
gc.collect()
await_names('watcher', 'kept')
print('an executor keeps its nodes')
(kept,) = executor.get_nodes()
executor.remove_node(kept)
del kept
drop(lambda: None)

name = rclpy.create_node('again').get_name()
drop(lambda: None)
again = rclpy.create_node(name)
again.get_logger().info('heard, and once')
again.destroy_node()
await_names('watcher')
rclpy.shutdown()
