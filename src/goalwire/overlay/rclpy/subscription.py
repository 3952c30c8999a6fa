"""rclpy.subscription: receives messages of a topic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from goalwire.entities.exceptions import InvalidHandle
from goalwire.entities.subscription import MessageInfo, MsgT, SubscriptionCore
from rclpy._borrowed import borrow
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.event_handler import EventHandler

__all__ = ['MessageInfo', 'Subscription']


class Subscription(SubscriptionCore[MsgT]):
    """Made by Node.create_subscription."""

    qos_profile: QoSProfile
    event_handlers: Sequence[EventHandler] = ()
    """The handlers of its events: the program's own and the default ones."""
    callback_group: CallbackGroup

    def get_publisher_count(self) -> int:
        """How many publishers there are; raises InvalidHandle once destroyed."""
        return self.publisher_count()

    @property
    def topic_name(self) -> str:
        """The fully-qualified name; raises InvalidHandle once destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self.full_name

    @property
    def callback(self) -> Callable[..., object]:
        """What is called with each message."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., object]) -> None:
        self.set_callback(value)

    @property
    def handle(self) -> Self:
        """The subscription itself: there is no C handle behind it."""
        return self

    def take_message(self, msg_type: type[MsgT], raw: bool) -> tuple[Any, MessageInfo] | None:
        """Take a message, as rclpy's handle offers it to waitables; None where there is none.

        It is one of this subscription's type, or serialized where that is `raw`.
        """
        return self.take()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()


borrow(__name__)
