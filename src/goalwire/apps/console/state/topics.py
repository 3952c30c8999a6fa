"""Topics: their rates, and their messages for views, received once for all browsers."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from time import monotonic, time_ns
from typing import Any

import goalwire
from goalwire.observe.messages import interface_class
from goalwire.observe.rates import Pace, Rate
from goalwire.observe.serialized_types import find_serialized_type
from goalwire.rules.qos import suiting

HEAVY = frozenset(
    {
        'sensor_msgs/msg/Image',
        'sensor_msgs/msg/CompressedImage',
        'sensor_msgs/msg/PointCloud',
        'sensor_msgs/msg/PointCloud2',
        'nav_msgs/msg/OccupancyGrid',
    }
)
"""Types whose messages are too large for a subscription that only measures the rate."""
_READ_DEPTH = 100

Listener = Callable[[Any, float], object]
"""Called with each message and the time of its arrival, by the monotonic clock."""


def _suiting(node: goalwire.Node, topic: str, depth: int) -> goalwire.QoS:
    return suiting([publisher.qos for publisher in node.graph.publishers(topic)], depth)


class Reader:
    """One subscription for all listeners of a topic. Each message is decoded once."""

    def __init__(
        self, node: goalwire.Node, topic: str, type_name: str, qos: goalwire.QoS | None = None
    ) -> None:
        """Raises UnknownInterfaceError."""
        self.topic = topic
        self.type_name = type_name
        self.latest: Any = None
        self.latest_at = 0.0
        self.count = 0
        self.listeners: list[Listener] = []
        self._subscription: goalwire.Subscription[Any] = node.subscription(
            interface_class(type_name), topic, qos=qos or _suiting(node, topic, _READ_DEPTH)
        )
        self._task = asyncio.get_running_loop().create_task(self._follow())

    async def _follow(self) -> None:
        async for message in self._subscription:
            now = monotonic()
            self.latest, self.latest_at = message, now
            self.count += 1
            for listener in list(self.listeners):
                listener(message, now)

    def close(self) -> None:
        """Stop listening."""
        self._task.cancel()
        self._subscription.close()


class Reading:
    """The use of a shared reader by one listener; `close` ends it."""

    def __init__(self, topics: Topics, reader: Reader, listener: Listener | None) -> None:
        self._topics = topics
        self._listener = listener
        self.reader = reader
        self.closed = False
        if listener is not None:
            reader.listeners.append(listener)
            if reader.latest is not None:
                listener(reader.latest, reader.latest_at)

    def close(self) -> None:
        """End the subscription. Idempotent."""
        if self.closed:
            return
        self.closed = True
        if self._listener is not None:
            self.reader.listeners.remove(self._listener)
        self._topics.release(self.reader)


class Meter:
    """Measures how often messages come to a topic, without work for each message.

    Its queue keeps only the latest message, with the time of its arrival. `read` takes it out now and then.
    """

    def __init__(self, node: goalwire.Node, topic: str, type_name: str) -> None:
        self.rate = Rate()
        self._read_at = monotonic()
        suiting, reliability = _suiting(node, topic, 1), goalwire.ReliabilityPolicy.BEST_EFFORT
        # A publisher of latched messages takes a reliable subscription to new ones for a mistake, and warns.
        if suiting.durability is not goalwire.DurabilityPolicy.TRANSIENT_LOCAL:
            reliability = suiting.reliability
        qos = goalwire.QoS(
            depth=1,
            reliability=reliability,
            durability=goalwire.DurabilityPolicy.VOLATILE,  # messages of the history come at once
        )
        self._subscription: goalwire.Subscription[Any] = node.subscription(
            find_serialized_type(node.context.graph, topic, type_name), topic, qos=qos, raw=True
        )

    async def read(self) -> Pace | None:
        """Return how many messages come in a second; None until it is known."""
        subscription, before = self._subscription, self._read_at
        self._read_at = now = monotonic()
        if subscription.statistics().waiting:
            await anext(subscription, None)
            counted, info = subscription.statistics(), subscription.info
            if info is not None:
                age = (time_ns() - info['received_timestamp']) / 1e9  # both times are of the wall clock
                self.rate.note(counted.received - counted.waiting, min(max(now - age, before), now))
        return self.rate.pace(now)

    def close(self) -> None:
        """Stop measuring."""
        self._subscription.close()


class Topics:
    """The subscriptions, and how many browsers look at each."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self._readers: dict[tuple[str, str], tuple[Reader, int]] = {}
        self._meters: dict[tuple[str, str], Meter] = {}
        self._measuring = 0
        self.rates: dict[str, float] = {}
        """The known rates by topic, in messages a second."""

    def read(
        self,
        topic: str,
        type_name: str,
        listener: Listener | None = None,
        qos: goalwire.QoS | None = None,
    ) -> Reading:
        """Listen to a topic by a shared subscription; without `qos` it gets a QoS that suits the publishers.

        Raises UnknownInterfaceError.
        """
        key = (topic, type_name)
        reader, users = self._readers.get(key, (None, 0))
        if reader is None:
            reader = Reader(self._node, topic, type_name, qos)
        self._readers[key] = (reader, users + 1)
        return Reading(self, reader, listener)

    def release(self, reader: Reader) -> None:
        """Note that one listener fewer needs the subscription."""
        key = (reader.topic, reader.type_name)
        known, users = self._readers[key]
        if users > 1:
            self._readers[key] = (known, users - 1)
        else:
            del self._readers[key]
            reader.close()

    # -- rates -----------------------------------------------------------------------------------------------

    def start_measuring(self) -> None:
        """Measure the rates of all topics for one page more, until `stop_measuring`."""
        self._measuring += 1
        self._look_for_meters()

    def stop_measuring(self) -> None:
        """Stop measuring for one page. After the last one, the subscriptions for rates end."""
        self._measuring -= 1
        if not self._measuring:
            self._close_meters()

    async def measure(self) -> None:
        """Read the rates. New topics are subscribed to, and subscriptions of gone ones end."""
        if not self._measuring:
            return
        self._look_for_meters()
        for key, meter in list(self._meters.items()):
            pace = await meter.read()
            if self._meters.get(key) is not meter:
                continue  # the meter was closed during `read`
            if pace is None:
                self.rates.pop(key[0], None)
            else:
                self.rates[key[0]] = pace.messages

    def _look_for_meters(self) -> None:
        wanted = {(name, types[0]) for name, types in self._node.graph.topics() if types[0] not in HEAVY}
        for key in self._meters.keys() - wanted:
            self._meters.pop(key).close()
            self.rates.pop(key[0], None)
        for topic, type_name in sorted(wanted - self._meters.keys()):
            with suppress(goalwire.GoalwireError):
                self._meters[topic, type_name] = Meter(self._node, topic, type_name)

    def _close_meters(self) -> None:
        for meter in self._meters.values():
            meter.close()
        self._meters.clear()
        self.rates.clear()

    def close(self) -> None:
        """End all subscriptions."""
        for reader, _ in self._readers.values():
            reader.close()
        self._readers.clear()
        self._close_meters()
