"""rclpy.publisher: publishes messages on a topic."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from goalwire.entities.exceptions import InvalidHandle
from goalwire.entities.publisher import MsgT, PublisherCore
from rclpy._borrowed import borrow
from rclpy.duration import Duration
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.event_handler import EventHandler

_FOREVER = Duration(seconds=-1)


class Publisher(PublisherCore[MsgT]):
    """Made by Node.create_publisher."""

    qos_profile: QoSProfile
    event_handlers: Sequence[EventHandler] = ()
    """The handlers of its events: the program's own and the default ones."""

    def get_subscription_count(self) -> int:
        """How many subscriptions there are; raises InvalidHandle once destroyed."""
        return self.subscription_count()

    @property
    def topic_name(self) -> str:
        """The fully-qualified name; raises InvalidHandle once destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self.full_name

    @property
    def handle(self) -> Self:
        """The publisher itself: there is no C handle behind it."""
        return self

    def assert_liveliness(self) -> None:
        """Show that this publisher is alive, where that is up to it; InvalidHandle once destroyed."""
        self.show_liveliness()

    def wait_for_all_acked(self, timeout: Duration = _FOREVER) -> bool:
        """Wait until every reliable subscription has all that was published; False where that takes too long.

        At once True on a wire that acknowledges by flow control alone. Raises InvalidHandle once destroyed.
        """
        return self.wait_for_acknowledgements(None if timeout.nanoseconds < 0 else timeout.nanoseconds)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()


borrow(__name__)
