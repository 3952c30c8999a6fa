"""Serves a topic, a service, an action and parameters, under whichever rclpy and RMW runs it."""

from __future__ import annotations

import sys
import time
from contextlib import suppress

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import SetBool

try:
    from test_msgs.action import Fibonacci  # type: ignore[import-not-found]  # of the real rclpy
except ImportError:
    from example_interfaces.action import Fibonacci

LARGEST = min(int(sys.argv[1]), 200_000)
"""Bytes of a long reply."""

rclpy.init()
node = rclpy.create_node('server')
node.declare_parameter('gain', 1.5)


def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.success = request.data
    response.message = 'long' * (LARGEST // 4) if request.data else 'short'
    return response


def count(goal: ServerGoalHandle) -> Fibonacci.Result:
    numbers = [0, 1]
    for _ in range(goal.request.order - 1):
        if goal.is_cancel_requested:
            goal.canceled()
            return Fibonacci.Result(sequence=numbers)
        numbers.append(numbers[-1] + numbers[-2])
        goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        time.sleep(0.02)
    goal.succeed()
    return Fibonacci.Result(sequence=numbers)


group = ReentrantCallbackGroup()
node.create_service(SetBool, 'set', answer)
pong = node.create_publisher(String, 'pong', 100)
node.create_subscription(String, 'ping', pong.publish, 100)
latched = node.create_publisher(
    String, 'latched', QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
)
latched.publish(String(data='said before'))
ways = [
    node.create_publisher(String, f'qos_{reliability.name}_{durability.name}'.lower(), qos)
    for reliability in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    for durability in (DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE)
    for qos in [QoSProfile(depth=1, reliability=reliability, durability=durability)]
]
timely = QoSProfile(depth=1, deadline=Duration(seconds=0.5), liveliness_lease_duration=Duration(seconds=3))
beating = [node.create_publisher(String, 'beat', timely)]


def speak() -> None:
    for way in ways:
        way.publish(String(data='spoken'))
    for beat in beating:
        beat.publish(String(data='beats'))


def hush(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    beating.clear()
    response.success = True
    return response


node.create_service(SetBool, 'hush', hush)


node.create_timer(0.05, speak)
ActionServer(
    node,
    Fibonacci,
    'count',
    count,
    callback_group=group,
    cancel_callback=lambda _: CancelResponse.ACCEPT,
)
executor = MultiThreadedExecutor(4)
executor.add_node(node)
print('ready', flush=True)
with suppress(KeyboardInterrupt, ExternalShutdownException):
    executor.spin()
