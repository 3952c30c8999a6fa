"""The minimal service and its clients, on /add_two_ints."""

from __future__ import annotations

from collections.abc import Sequence

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from goalwire.apps.programs.running import spin

A, B = 41, 1


class MinimalService(Node):
    """Answers `add_two_ints` with a + b."""

    def __init__(self) -> None:
        super().__init__('minimal_service')
        self.create_service(AddTwoInts, 'add_two_ints', self._add)

    def _add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        self.get_logger().info(f'Incoming request\na: {request.a} b: {request.b}')
        return response


def serve(args: Sequence[str] | None = None) -> int:
    """Run the service."""
    return spin(MinimalService, args)


def ask(args: Sequence[str] | None = None) -> int:
    """Wait for the service, ask for 41 + 1 and log the answer; returns the exit code."""
    try:
        with rclpy.init(args=None if args is None else list(args)):
            node = rclpy.create_node('minimal_client')
            client = node.create_client(AddTwoInts, 'add_two_ints')
            while not client.wait_for_service(timeout_sec=1.0):
                node.get_logger().info('service not available, waiting again...')
            future = client.call_async(AddTwoInts.Request(a=A, b=B))
            rclpy.spin_until_future_complete(node, future)
            response = future.result()
            if response is None:
                return 1
            node.get_logger().info(f'Result of add_two_ints: for {A} + {B} = {response.sum}')
            return 0
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
