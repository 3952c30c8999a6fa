"""rclpy.experimental.async_subscription: receives messages in an asyncio loop."""

from __future__ import annotations

from goalwire.entities.type_support import MsgT
from rclpy.impl.endpoint import Adopted
from rclpy.subscription import Subscription


class AsyncSubscription(Adopted, Subscription[MsgT]):
    """Receives one topic. Made by AsyncNode.create_subscription."""

    @property
    def is_cft_enabled(self) -> bool:
        """Always False: goalwire does not filter by content."""
        return False
