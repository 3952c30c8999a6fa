"""rclpy.experimental.async_publisher: publishes messages, from an asyncio program."""

from __future__ import annotations

from goalwire.entities.type_support import MsgT
from rclpy.impl.endpoint import Adopted
from rclpy.publisher import Publisher


class AsyncPublisher(Adopted, Publisher[MsgT]):
    """Made by AsyncNode.create_publisher. `publish` does not wait, so it is not a coroutine."""
