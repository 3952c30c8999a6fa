"""rclpy.experimental.async_timer: periodic callbacks in an asyncio loop."""

from __future__ import annotations

from rclpy.impl.endpoint import Adopted
from rclpy.timer import Timer


class AsyncTimer(Adopted, Timer):
    """Calls its callback periodically. Made by AsyncNode.create_timer."""
