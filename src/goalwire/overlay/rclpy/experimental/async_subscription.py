"""rclpy.experimental.async_subscription: receives messages in an asyncio loop."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.entities.subscription import MsgT
from rclpy.subscription import Subscription


class AsyncSubscription(Subscription[MsgT]):
    """Made by AsyncNode.create_subscription."""

    on_destroy: Callable[[], object] | None = None

    @property
    def is_cft_enabled(self) -> bool:
        """False: no wire of goalwire filters by content."""
        return False

    def destroy(self) -> None:
        """Undeclare, and cancel the callbacks that run, save one that calls this. Idempotent."""
        super().destroy()
        if self.on_destroy is not None:
            self.on_destroy()
