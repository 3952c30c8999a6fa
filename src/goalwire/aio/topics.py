"""Publishers and subscriptions of the asyncio API."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar, cast

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.call_deadlines import CallContext
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.qos_events import warn_by_default
from goalwire.entities.subscription import SubscriptionCore, queue_depth
from goalwire.execution.asyncio.waiting import AsyncQueue
from goalwire.execution.callback_groups import ReentrantCallbackGroup

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self

    from goalwire.entities.node import NodeCore
    from goalwire.entities.subscription import MessageInfo
    from goalwire.entities.type_support import MessageSupport
    from goalwire.rules.qos import QoS
    from goalwire.rules.statistics import PublisherStatistics, SubscriptionStatistics
    from goalwire.transport.contract import Sample


MsgT = TypeVar('MsgT')


class Publisher(Entity, Generic[MsgT]):
    """Publishes on one topic. Made by Node.publisher."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._core: PublisherCore[MsgT] = PublisherCore(node, msg_type, topic, qos)
        self.name = self._core.full_name
        warn_by_default(self._core, topic)

    def publish(self, message: MsgT | None = None, /, **fields: object) -> None:
        """Send a message, given or made of `fields`. It does not wait, so it is not a coroutine.

        Raises TypeError for another type, EncodeError for a field that cannot be encoded, InvalidHandle
        once closed, ShutDownError.
        """
        core = self._core
        core.publish(cast('MsgT', message_of(core.msg_type, message, fields)))

    def subscribers(self) -> int:
        """Return how many subscriptions match. Raises InvalidHandle once closed."""
        return self._core.subscription_count()

    async def wait_for_subscribers(self, count: int = 1, *, timeout: float | None = None) -> None:
        """Wait until that many subscriptions match, `timeout` s at most.

        Raises DeadlineError, InvalidHandle once closed, ShutDownError.
        """
        attempt = CallContext(self._core.node.context, 'topic', self.name, timeout)
        await attempt.shows(lambda: self._core.subscription_count() >= count, 'too few subscribers came')

    def statistics(self) -> PublisherStatistics:
        """Return the counts of published messages."""
        return self._core.statistics()

    def close(self) -> None:
        """Stop publishing. Idempotent."""
        self._core.destroy()


class _Core(SubscriptionCore[MsgT]):
    """Puts arriving messages into a stream, without a callback in the node's executor."""

    def __init__(
        self,
        node: NodeCore,
        msg_type: type[MsgT] | MessageSupport,
        topic: str,
        qos: QoS,
        *,
        raw: bool = False,
    ) -> None:
        self.stream: AsyncQueue[Sample] = AsyncQueue(queue_depth(qos))
        self._note_arrival: Callable[[Sample], None] | None = None
        super().__init__(node, msg_type, topic, bool, qos, ReentrantCallbackGroup(), raw=raw)

    def _receiver(self) -> Callable[[Sample], None]:
        return self._deliver

    def _watch_arrivals(self, note: Callable[[Sample], None]) -> None:
        self._note_arrival = note

    def _deliver(self, sample: Sample) -> None:
        if self._note_arrival is not None:
            self._note_arrival(sample)
        self.stream.deliver(sample)

    def statistics(self) -> SubscriptionStatistics:
        return self._count(len(self.stream), self.stream.dropped)

    def destroy(self) -> None:
        super().destroy()
        self.stream.close()


class Subscription(Entity, Generic[MsgT]):
    """A subscription: `async for message in subscription`. The loop ends when it is closed.

    Up to the QoS's depth messages wait; beyond this the oldest is dropped and counted.
    """

    def __init__(
        self,
        node: NodeCore,
        msg_type: type[MsgT] | MessageSupport,
        topic: str,
        qos: QoS,
        *,
        raw: bool = False,
    ) -> None:
        self._core: _Core[MsgT] = _Core(node, msg_type, topic, qos, raw=raw)
        self.name = self._core.full_name
        self.info: MessageInfo | None = None
        """The times at which the latest message given out was sent and received, and its number."""
        warn_by_default(self._core, topic)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> MsgT:
        """Wait for the next message. Messages that cannot be decoded are logged and left out."""
        while True:
            taken: tuple[MsgT, MessageInfo] | None = self._core.read(await anext(self._core.stream))
            if taken is not None:
                message, self.info = taken
                return message

    @property
    def dropped(self) -> int:
        """How many messages were dropped because too many were waiting."""
        return self._core.stream.dropped

    def statistics(self) -> SubscriptionStatistics:
        """Return the counts of received messages."""
        return self._core.statistics()

    def publishers(self) -> int:
        """Return how many publishers match. Raises InvalidHandle once closed."""
        return self._core.publisher_count()

    async def wait_for_publishers(self, count: int = 1, *, timeout: float | None = None) -> None:
        """Wait until that many publishers match, `timeout` s at most.

        Raises DeadlineError, InvalidHandle once closed, ShutDownError.
        """
        attempt = CallContext(self._core.node.context, 'topic', self.name, timeout)
        await attempt.shows(lambda: self._core.publisher_count() >= count, 'too few publishers came')

    def close(self) -> None:
        """Stop receiving. Waiting messages are still given out. Idempotent."""
        self._core.destroy()
