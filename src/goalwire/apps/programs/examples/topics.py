"""The minimal publisher and the minimal subscriber, on /topic."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import String

from goalwire.apps.programs.running import spin


class MinimalPublisher(Node):
    """Publishes 'Hello World: N' on `topic` twice a second."""

    def __init__(self) -> None:
        super().__init__('minimal_publisher')
        self._publisher = self.create_publisher(String, 'topic', 10)
        self._next = 0
        self.create_timer(0.5, self._publish)

    def _publish(self) -> None:
        message = String(data=f'Hello World: {self._next}')
        self._publisher.publish(message)
        self.get_logger().info(f'Publishing: "{message.data}"')
        self._next += 1


class MinimalSubscriber(Node):
    """Logs the messages on `topic`."""

    def __init__(self) -> None:
        super().__init__('minimal_subscriber')
        self.create_subscription(String, 'topic', self._hear, 10)

    def _hear(self, message: String) -> None:
        self.get_logger().info(f'I heard: "{message.data}"')


def publish(args: Sequence[str] | None = None) -> int:
    """Run the publisher."""
    return spin(MinimalPublisher, args)


def subscribe(args: Sequence[str] | None = None) -> int:
    """Run the subscriber."""
    return spin(MinimalSubscriber, args)
