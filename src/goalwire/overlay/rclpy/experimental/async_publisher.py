"""rclpy.experimental.async_publisher: publishes messages, from an asyncio program."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.entities.publisher import MsgT
from rclpy.publisher import Publisher


class AsyncPublisher(Publisher[MsgT]):
    """Made by AsyncNode.create_publisher. `publish` does not wait, so it is no coroutine."""

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """Undeclare. Idempotent."""
        super().destroy()
        if self.on_destroy is not None:
            self.on_destroy()
