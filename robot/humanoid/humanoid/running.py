"""Run one node as one program: until Ctrl-C, SIGTERM or the end of whoever started it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def run(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Spin the node on one thread until it is told to stop, which is a success: exit code 0."""
    node = None
    try:
        rclpy.init(args=args)
        node = make_node()
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
