"""Recorders and publishers of topics, for tests."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.aio.entity import message_of
from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.subscription import SubscriptionCore
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.testing.log import PATIENCE, Log

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Sample

MsgT = TypeVar('MsgT')


class _Core(SubscriptionCore[MsgT]):
    """A subscription that decodes messages as soon as they arrive, without an executor."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self.messages: Log[MsgT] = Log(f"messages on '{node.resolve(topic)}'")
        self.times: list[float] = []
        super().__init__(node, msg_type, topic, bool, qos, ReentrantCallbackGroup())

    def _receiver(self) -> Callable[[Sample], None]:
        return self._deliver

    def _deliver(self, sample: Sample) -> None:
        taken = self.read(sample)
        if taken is not None:
            self.times.append(monotonic())
            self.messages.append(taken[0])


class Recorder(Generic[MsgT]):
    """Keeps the messages of one topic. Made by Graph.record."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._node = node
        self._core: _Core[MsgT] = _Core(node, msg_type, topic, qos)
        self.name = self._core.full_name
        self.messages = self._core.messages
        """The messages that have come so far."""
        self.times = self._core.times
        """The time of each message's arrival, in s of time.monotonic()."""

    def wait_for(self, count: int = 1, *, timeout: float = PATIENCE) -> list[MsgT]:
        """Block until `count` messages have come; raises AssertionError after `timeout` s."""
        return self.messages.wait_for(count, timeout=timeout)

    def wait_for_publisher(self, count: int = 1, *, timeout: float = PATIENCE) -> None:
        """Block until the topic has `count` publishers; raises AssertionError after `timeout` s."""
        _wait_for_peers(self._node, self.name, 'publishers', self._core.publisher_count, count, timeout)

    def close(self) -> None:
        """Stop listening. Idempotent."""
        self._node.destroy()


class Publisher(Generic[MsgT]):
    """Publishes on one topic. Made by Graph.publisher."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._node = node
        self._core: PublisherCore[MsgT] = PublisherCore(node, msg_type, topic, qos)
        self.name = self._core.full_name

    def publish(self, message: MsgT | None = None, /, **fields: object) -> None:
        """Publish the given message, or one that is made of `fields`."""
        self._core.publish(message_of(self._core.msg_type, message, fields))  # type: ignore[arg-type]

    def wait_for_subscriber(self, count: int = 1, *, timeout: float = PATIENCE) -> None:
        """Block until the topic has `count` subscriptions; raises AssertionError after `timeout` s."""
        _wait_for_peers(self._node, self.name, 'subscriptions', self._core.subscription_count, count, timeout)

    def close(self) -> None:
        """Stop publishing. Idempotent."""
        self._node.destroy()


def _wait_for_peers(
    node: NodeCore, topic: str, what: str, counted: Callable[[], int], count: int, timeout: float
) -> None:
    if not wait_for_graph(node.context, lambda: counted() >= count, timeout):
        raise AssertionError(f"wanted {count} {what} of '{topic}' within {timeout:g} s, got {counted()}")
