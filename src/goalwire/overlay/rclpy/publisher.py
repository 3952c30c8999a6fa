"""rclpy.publisher: publishes messages on a topic."""

from __future__ import annotations

from goalwire.entities.publisher import PublisherCore
from goalwire.entities.type_support import MsgT
from rclpy._reexports import reexport
from rclpy.duration import Duration
from rclpy.impl.endpoint import TopicEndpoint

_FOREVER = Duration(seconds=-1)


class Publisher(PublisherCore[MsgT], TopicEndpoint):
    """Publishes on one topic. Made by Node.create_publisher."""

    def get_subscription_count(self) -> int:
        """Return how many subscriptions match this publisher; raises InvalidHandle once destroyed."""
        return self.subscription_count()

    def assert_liveliness(self) -> None:
        """Assert that this publisher is alive, for MANUAL_BY_TOPIC liveliness; raises InvalidHandle once
        destroyed.
        """
        self.show_liveliness()

    def wait_for_all_acked(self, timeout: Duration = _FOREVER) -> bool:
        """Wait until every reliable subscription has acknowledged all messages; False after a timeout.

        On a wire that has only flow control, without acknowledgements, this returns True at once. Raises
        InvalidHandle once destroyed.
        """
        return self.wait_for_acknowledgements(None if timeout.nanoseconds < 0 else timeout.nanoseconds)


reexport(__name__)
