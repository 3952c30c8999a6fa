"""goalwire's round trips between two processes, as a program written for rclpy makes them.

As a program: `python -m benchmarks.round_trips server` answers until it is stopped;
`python -m benchmarks.round_trips service N` and `... topic N` print N times in seconds as JSON.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from time import perf_counter

import rclpy
from geometry_msgs.msg import PoseStamped
from humanoid_interfaces.srv import GetJointState
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

SERVICE = 'bench_joint_state'
PING, PONG = 'bench_ping', 'bench_pong'
WARM_UP = 200


def serve() -> None:
    """Answer calls and send poses back, through callbacks."""
    rclpy.init()
    node = Node('bench_server')
    pong = node.create_publisher(PoseStamped, PONG, 10)
    node.create_subscription(PoseStamped, PING, pong.publish, 10)

    def answer(_request: GetJointState.Request, response: GetJointState.Response) -> GetJointState.Response:
        response.position = 0.5
        return response

    node.create_service(GetJointState, SERVICE, answer)
    print('ready', flush=True)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def service_round_trip(node: Node) -> Callable[[], None]:
    """Return one call: call_async, then spin until its future is complete."""
    client = node.create_client(GetJointState, SERVICE)
    if not client.wait_for_service(10.0):
        sys.exit(f'nobody serves {SERVICE}')
    request = GetJointState.Request(joint_name='left_arm_shoulder')

    def call() -> None:
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future)
        future.result()

    return call


def topic_round_trip(node: Node) -> Callable[[], None]:
    """Return one exchange: publish a pose, spin until it has come back."""
    received: list[PoseStamped] = []
    node.create_subscription(PoseStamped, PONG, received.append, 10)
    ping = node.create_publisher(PoseStamped, PING, 10)
    pose = PoseStamped()
    pose.header.frame_id = 'map'

    def exchange() -> None:
        received.clear()
        ping.publish(pose)
        while not received:
            rclpy.spin_once(node, timeout_sec=1.0)

    while not received:  # until both ends have found each other
        ping.publish(pose)
        rclpy.spin_once(node, timeout_sec=0.1)
    return exchange


def measure(what: str, count: int) -> list[float]:
    """Return `count` times in seconds."""
    rclpy.init()
    node = Node('bench_client')
    once = {'service': service_round_trip, 'topic': topic_round_trip}[what](node)
    times = []
    for index in range(WARM_UP + count):
        start = perf_counter()
        once()
        if index >= WARM_UP:
            times.append(perf_counter() - start)
    node.destroy_node()
    rclpy.shutdown()
    return times


if __name__ == '__main__':
    if sys.argv[1] == 'server':
        serve()
    else:
        print(json.dumps(measure(sys.argv[1], int(sys.argv[2]))))
