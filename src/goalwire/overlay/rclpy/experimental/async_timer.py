"""rclpy.experimental.async_timer: callbacks at a rhythm, in an asyncio loop."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.timer import Timer


class AsyncTimer(Timer):
    """Made by AsyncNode.create_timer."""

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """End it, and cancel the callback that runs, save where that calls this. Idempotent."""
        super().destroy()
        if self.on_destroy is not None:
            self.on_destroy()
