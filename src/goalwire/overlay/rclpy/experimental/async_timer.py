"""rclpy.experimental.async_timer: callbacks at a rhythm, in an asyncio loop."""

from __future__ import annotations

from rclpy.impl.endpoint import Adopted
from rclpy.timer import Timer


class AsyncTimer(Adopted, Timer):
    """Calls at a steady rhythm. Made by AsyncNode.create_timer."""
