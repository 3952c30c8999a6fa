"""The action that the benchmarks use: ROS 2's Fibonacci, from whichever package is there.

The real rclpy finds it in PyPI's test_msgs, goalwire in its own example_interfaces; they are alike.
"""

try:
    from example_interfaces.action import Fibonacci
except ImportError:
    from test_msgs.action import Fibonacci  # type: ignore[import-not-found,no-redef]

__all__ = ['Fibonacci']
