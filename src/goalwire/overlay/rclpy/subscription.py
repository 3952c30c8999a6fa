"""rclpy.subscription: receives messages of a topic."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any

from goalwire.entities.subscription import MessageInfo, SubscriptionCore
from goalwire.entities.type_support import MsgT
from rclpy._reexports import reexport
from rclpy.callback_groups import CallbackGroup
from rclpy.impl.endpoint import TopicEndpoint

__all__ = ['MessageInfo', 'Subscription']


class Subscription(SubscriptionCore[MsgT], TopicEndpoint):
    """Receives one topic. Made by Node.create_subscription."""

    callback_group: CallbackGroup

    class CallbackType(Enum):
        """The arguments of the callback: the message, or the message and its MessageInfo."""

        MessageOnly = 0
        WithMessageInfo = 1

    @property
    def _callback_type(self) -> CallbackType:
        """The arguments of the callback. Programs read this private name of rclpy."""
        return self.CallbackType(int(self._wants_info))

    def get_publisher_count(self) -> int:
        """Return how many publishers match this subscription; raises InvalidHandle once destroyed."""
        return self.publisher_count()

    @property
    def callback(self) -> Callable[..., object]:
        """The callback, which gets each message."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., object]) -> None:
        self.set_callback(value)

    def take_message(self, msg_type: type[MsgT], raw: bool) -> tuple[Any, MessageInfo] | None:
        """Take a waiting message, as waitables do with rclpy's handle; return None if there is no message.

        The message has this subscription's type, or is serialized if the subscription is `raw`.
        """
        return self.take()


reexport(__name__)
