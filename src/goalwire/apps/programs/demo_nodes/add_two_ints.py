"""add_two_ints_server and its clients: the service of the tutorials."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from goalwire.apps.programs.running import spin

SERVICE = 'add_two_ints'


class AddTwoIntsServer(Node):
    """Answers `add_two_ints` with the sum of a and b, a 64-bit number that overflows as in C."""

    def __init__(self, name: str = 'add_two_ints_server') -> None:
        super().__init__(name)
        self.create_service(AddTwoInts, SERVICE, self._add)

    def _add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = (request.a + request.b + 2**63) % 2**64 - 2**63
        self.get_logger().info(f'Incoming request\na: {request.a} b: {request.b}')
        return response


def serve(args: Sequence[str] | None = None) -> int:
    """Run the server."""
    return spin(AddTwoIntsServer, args)


def ask(argv: Sequence[str] | None = None) -> int:
    """Call the service once with `a b` (default: 2 3), log the sum, and return the exit code."""
    words = rclpy.utilities.remove_ros_args(sys.argv if argv is None else argv)[1:]
    try:
        a, b = (int(word) for word in words or ('2', '3'))
        request = AddTwoInts.Request(a=a, b=b)
    except (AssertionError, ValueError):
        print('usage: add_two_ints_client [A B], two numbers of 64 bits', file=sys.stderr)
        return 1
    return call_once('add_two_ints_client', request, 'Result of add_two_ints: {sum}', argv)


def call_once(name: str, request: AddTwoInts.Request, said: str, args: Sequence[str] | None) -> int:
    """Wait for the service, send a request, log the sum in the format `said`, and return the exit code."""
    try:
        with rclpy.init(args=None if args is None else list(args)):
            node = rclpy.create_node(name)
            client = node.create_client(AddTwoInts, SERVICE)
            while not client.wait_for_service(timeout_sec=1.0):
                node.get_logger().info('service not available, waiting again...')
            future = client.call_async(request)
            rclpy.spin_until_future_complete(node, future)
            response = future.result()
            if response is None:
                return 1
            node.get_logger().info(said.format(sum=response.sum))
            return 0
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
