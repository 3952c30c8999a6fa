"""Publishes messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar, cast

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.call_context import CallContext
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.qos_events import warn_by_default

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from goalwire.rules.statistics import PublisherStatistics

MsgT = TypeVar('MsgT')


class Publisher(Entity, Generic[MsgT]):
    """Made by Node.publisher."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._core: PublisherCore[MsgT] = PublisherCore(node, msg_type, topic, qos)
        self.name = self._core.full_name
        warn_by_default(self._core, topic)

    def publish(self, message: MsgT | None = None, /, **fields: object) -> None:
        """Send a message, or one that is made of `fields`. Does not wait, so it is no coroutine.

        Raises TypeError for another type, EncodeError where a field cannot go on the wire, InvalidHandle
        once closed, ShutDownError.
        """
        core = self._core
        core.publish(cast('MsgT', message_of(core.msg_type, message, fields)))

    def subscribers(self) -> int:
        """How many subscriptions match; raises InvalidHandle once closed."""
        return self._core.subscription_count()

    async def wait_for_subscribers(self, count: int = 1, *, timeout: float | None = None) -> None:
        """Wait until that many subscriptions match, `timeout` s at most.

        Raises DeadlineError, InvalidHandle once closed, ShutDownError.
        """
        attempt = CallContext(self._core.node.context, 'topic', self.name, timeout)
        await attempt.shows(lambda: self._core.subscription_count() >= count, 'too few subscribers came')

    def statistics(self) -> PublisherStatistics:
        """Count what was published."""
        return self._core.statistics()

    def close(self) -> None:
        """Publish no more. Idempotent."""
        self._core.destroy()
