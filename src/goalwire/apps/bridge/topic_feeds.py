"""Subscribes to each topic once for all clients, and decodes each message at most once.

A topic with history (transient local) is an exception: each listener has its own subscription, because a
shared one would deliver the history only to the first client.
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
from goalwire.fault_reports import log_rejected
from goalwire.rules.qos import QoS, suiting
from goalwire.transport.contract import Sample

DEPTH = 100
"""Depth of the bridge's subscriptions."""


class Arrival:
    """A received message, and its encoded forms, each made once when a client first needs it."""

    def __init__(self, sample: Sample, cls: Any) -> None:
        self._sample = sample
        self._cls = cls
        self.forms: dict[str, Any] = {}
        """The encoded forms of the message, by keys that the protocols choose."""

    @cached_property
    def data(self) -> bytes:
        """The serialized message."""
        return bytes(self._sample.payload)

    @property
    def time(self) -> int:
        """The time of sending, or of receiving if the wire gives no time of sending, in ns since 1970."""
        return self._sample.source_timestamp or self._sample.received_timestamp

    @cached_property
    def message(self) -> Any:
        """The message. Raises DecodeError."""
        return codec.decoder(self._cls)(self._sample.payload)

    def form(self, key: str, make: Callable[[Arrival], Any]) -> Any:
        """Return the encoded form with this key; `make` encodes the message when it is first requested."""
        if key not in self.forms:
            self.forms[key] = make(self)
        return self.forms[key]


class Listener(Protocol):
    """A client's subscription."""

    def take(self, arrival: Arrival) -> None:
        """Take a message on the loop's thread; must not block. The caller counts and logs DecodeErrors."""


class Feeds:
    """The subscriptions for all clients. Only for the loop's thread."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self._feeds: set[_Feed] = set()

    def listen(self, topic: str, type_name: str, cls: Any, listener: Listener) -> Callable[[], None]:
        """Subscribe a listener to a topic with a full name; return the function that ends the subscription.

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
        """Subscribe again whenever the QoS of a topic's publishers changes, until cancelled."""
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
        """The time of each publisher's latest message."""
        self._had: dict[bytes, int] = {}
        """By publisher: the time of its latest message before the last `subscribe`.

        The new subscription receives history up to these times again; those messages are ignored.
        """
        self._subscription: RawSubscription | None = None
        self.subscribe(qos)
        self._task = asyncio.get_running_loop().create_task(self._hand_out())

    @property
    def is_shared(self) -> bool:
        return not self.qos.is_transient_local

    def subscribe(self, qos: QoS) -> None:
        """Subscribe with a QoS; an earlier subscription is closed first."""
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
