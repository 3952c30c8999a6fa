"""talker_qos and listener_qos: talker and listener with best effort, or with --reliable."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Sequence

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, QoSReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import String

from goalwire.apps.programs.running import spin


class _Counting(Node):
    """A node that ends its program after a given number of messages."""

    def __init__(self, name: str, arguments: Namespace) -> None:
        super().__init__(name)
        if arguments.reliable:
            self.qos = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.RELIABLE)
            self.get_logger().info(f'Reliable {name}')
        else:
            self.qos = qos_profile_sensor_data
            self.get_logger().info(f'Best effort {name}')
        self._count = 0
        self._cycles: int = arguments.number_of_cycles

    def count(self) -> int:
        """Count a message, and return how many came before it."""
        before = self._count
        self._count += 1
        if self._count == self._cycles:
            self.context.try_shutdown()
        return before


class TalkerQos(_Counting):
    """Publishes 'Hello World: N' on `chatter` once a second."""

    def __init__(self, arguments: Namespace) -> None:
        super().__init__('talker_qos', arguments)
        self._publisher = self.create_publisher(String, 'chatter', self.qos)
        self.create_timer(1.0, self._talk)

    def _talk(self) -> None:
        message = String(data=f'Hello World: {self._count}')
        self.get_logger().info(f'Publishing: "{message.data}"')
        self._publisher.publish(message)
        self.count()


class ListenerQos(_Counting):
    """Logs the messages on `chatter`."""

    def __init__(self, arguments: Namespace) -> None:
        super().__init__('listener_qos', arguments)
        self.create_subscription(String, 'chatter', self._hear, self.qos)

    def _hear(self, message: String) -> None:
        self.get_logger().info(f'I heard: [{message.data}]')
        self.count()


def _run(make_node: Callable[[Namespace], Node], argv: Sequence[str] | None) -> int:
    parser = ArgumentParser()
    parser.add_argument('--reliable', action='store_true', help='set the QoS to reliable')
    parser.add_argument(
        '-n', '--number_of_cycles', type=int, default=20, help='number of messages before the program ends'
    )
    words = rclpy.utilities.remove_ros_args(argv)[1:]
    arguments = parser.parse_args(words)
    return spin(lambda: make_node(arguments), argv)


def talk(argv: Sequence[str] | None = None) -> int:
    """Run talker_qos."""
    return _run(TalkerQos, argv)


def listen(argv: Sequence[str] | None = None) -> int:
    """Run listener_qos."""
    return _run(ListenerQos, argv)
