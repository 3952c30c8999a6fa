"""rclpy.experimental.async_publisher: publishes messages, from an asyncio program."""

from __future__ import annotations

from goalwire.entities.type_support import MsgT
from rclpy.impl.endpoint import Adopted
from rclpy.publisher import Publisher


class AsyncPublisher(Adopted, Publisher[MsgT]):
    """Publishes on one topic, without waiting: `publish` is not a coroutine.

    Made by AsyncNode.create_publisher.
    """
