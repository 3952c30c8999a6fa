"""talker: one String a second on /chatter."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from goalwire.apps.programs.running import spin


class Talker(Node):
    """Publishes 'Hello World: N' on `chatter` once a second, with N from `first` on."""

    def __init__(self, first: int = 0, said: str = 'Publishing: "{}"', qos: QoSProfile | int = 10) -> None:
        super().__init__('talker')
        self._next = first
        self._said = said
        self._publisher = self.create_publisher(String, 'chatter', qos)
        self.create_timer(1.0, self._talk)

    def _talk(self) -> None:
        message = String(data=f'Hello World: {self._next}')
        self._next += 1
        self.get_logger().info(self._said.format(message.data))
        self._publisher.publish(message)


def main(args: Sequence[str] | None = None) -> int:
    """Run demo_nodes_py's talker."""
    return spin(Talker, args)


def main_cpp(args: Sequence[str] | None = None) -> int:
    """Run demo_nodes_cpp's talker."""
    return spin(lambda: Talker(1, "Publishing: '{}'", 7), args)
