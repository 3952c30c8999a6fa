"""Messages of topics: one subscription for all clients of a topic, each message decoded at most once.

A topic with history is an exception. Each of its listeners has a subscription of its own, since one that is
shared would give the history to the first client alone.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import cached_property
from typing import Any, Protocol

import goalwire
from goalwire.aio.raw import RawSubscription
from goalwire.cdr import codec
from goalwire.errors import DecodeError
from goalwire.execution.asyncio.waiting import AsyncQueue
from goalwire.reports import log_rejected
from goalwire.rules.qos import QoS, suiting
from goalwire.transport.contract import Sample

DEPTH = 100
"""Messages of a topic that wait for the bridge itself."""


class Arrival:
    """A message that has come; each of its forms is made when a client needs it first, and kept."""

    def __init__(self, sample: Sample, cls: Any) -> None:
        self._sample = sample
        self._cls = cls
        self.forms: dict[str, Any] = {}
        """The forms that protocols have made of the message, by their own keys."""

    @cached_property
    def data(self) -> bytes:
        """The serialized message."""
        return bytes(self._sample.payload)

    @property
    def time(self) -> int:
        """When it was sent, in ns since 1970; when it came, if the wire does not say."""
        return self._sample.source_timestamp or self._sample.received_timestamp

    @cached_property
    def message(self) -> Any:
        """The message. Raises DecodeError."""
        return codec.decoder(self._cls)(self._sample.payload)

    def form(self, key: str, make: Callable[[Arrival], Any]) -> Any:
        """Return a form of the message, which `make` makes once for all clients."""
        if key not in self.forms:
            self.forms[key] = make(self)
        return self.forms[key]


class Listener(Protocol):
    """A client's subscription."""

    def take(self, arrival: Arrival) -> None:
        """Take a message, in the loop, without waiting. Its DecodeErrors are counted and logged."""


class Feeds:
    """The topics that clients listen to. Only for the loop's thread."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self._feeds: set[_Feed] = set()

    def listen(self, topic: str, type_name: str, cls: Any, listener: Listener) -> Callable[[], None]:
        """Give a listener what arrives on a topic, which is named in full; call the answer to end that.

        `cls` is the message class; None if no listener decodes. Raises InvalidTopicNameException.
        """
        qos = self._suiting(topic)
        shared = (
            feed
            for feed in self._feeds
            if feed.is_shared and (feed.topic, feed.type_name, feed.cls) == (topic, type_name, cls)
        )
        feed = None if qos.is_transient_local else next(shared, None)
        if feed is None:
            feed = _Feed(self._node, topic, type_name, cls, qos)
            self._feeds.add(feed)
        feed.listeners[listener] = None

        def stop() -> None:
            feed.listeners.pop(listener, None)
            if not feed.listeners and feed in self._feeds:
                self._feeds.remove(feed)
                feed.close()

        return stop

    def _suiting(self, topic: str) -> QoS:
        publishers = self._node.graph.publishers(topic)
        return suiting([each.qos for each in publishers], DEPTH)

    async def follow_graph(self) -> None:
        """Subscribe anew if publishers with another QoS have come, until it is cancelled."""
        async for _ in self._node.graph.changes():
            for feed in list(self._feeds):
                qos = self._suiting(feed.topic)
                if qos != feed.qos and self._node.graph.publishers(feed.topic):
                    feed.subscribe(qos)

    def close(self) -> None:
        """End every subscription."""
        for feed in self._feeds:
            feed.close()
        self._feeds.clear()


class _Feed:
    def __init__(self, node: goalwire.Node, topic: str, type_name: str, cls: Any, qos: QoS) -> None:
        self._node = node
        self.topic = topic
        self.type_name = type_name
        self.cls = cls
        self.qos = qos
        self.listeners: dict[Listener, None] = {}
        self._broken = 0
        self._queue: AsyncQueue[Sample] = AsyncQueue(DEPTH)
        self._latest: dict[bytes, int] = {}
        """When each publisher sent its latest message."""
        self._had: dict[bytes, int] = {}
        """The same times at the latest `subscribe`: history up to these comes a second time."""
        self._subscription: RawSubscription | None = None
        self.subscribe(qos)
        self._task = asyncio.get_running_loop().create_task(self._hand_out())

    @property
    def is_shared(self) -> bool:
        return not self.qos.is_transient_local

    def subscribe(self, qos: QoS) -> None:
        """Subscribe, or do so anew with another QoS."""
        if self._subscription is not None:
            self._subscription.close()
        self.qos = qos
        self._had, self._latest = self._latest, {}
        self._subscription = self._node.raw_subscription(
            self.topic, self.type_name, self._queue.deliver, qos=qos
        )

    async def _hand_out(self) -> None:
        async for sample in self._queue:
            self._latest[sample.gid] = sample.source_timestamp
            if sample.source_timestamp > self._had.get(sample.gid, 0) or not sample.source_timestamp:
                self._give(Arrival(sample, self.cls))

    def _give(self, arrival: Arrival) -> None:
        for listener in list(self.listeners):
            try:
                listener.take(arrival)
            except DecodeError as error:
                self._broken += 1
                what = f"topic '{self.topic}': a message was not given to a client"
                log_rejected(self._node.logger.name, what, self._broken, error)

    def close(self) -> None:
        self._task.cancel()
        self._queue.discard()
        if self._subscription is not None:
            self._subscription.close()
