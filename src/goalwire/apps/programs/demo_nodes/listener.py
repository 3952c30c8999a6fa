"""listener: logs the Strings on /chatter."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from std_msgs.msg import String

from goalwire.apps.programs.running import spin


class Listener(Node):
    """Logs the messages on `chatter`."""

    def __init__(self, qos: QoSProfile | int = 10) -> None:
        super().__init__('listener')
        self.create_subscription(String, 'chatter', self._hear, qos)

    def _hear(self, message: String) -> None:
        self.get_logger().info(f'I heard: [{message.data}]')


def main(args: Sequence[str] | None = None) -> int:
    """Run the listener of both packages."""
    return spin(Listener, args)


def main_best_effort(args: Sequence[str] | None = None) -> int:
    """Run demo_nodes_cpp's listener_best_effort, which hears every publisher."""
    return spin(lambda: Listener(qos_profile_sensor_data), args)
