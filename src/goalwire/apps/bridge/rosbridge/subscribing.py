"""The operations subscribe and unsubscribe."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from time import monotonic
from typing import Any

from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.outbox import Frame
from goalwire.apps.bridge.rosbridge.client import (
    Client,
    Operation,
    compression_of,
    number_of,
    text_of,
)
from goalwire.apps.bridge.rosbridge.encoding import cbor, frames, json_text
from goalwire.apps.bridge.rosbridge.values import to_cbor, to_json
from goalwire.apps.bridge.topic_feeds import Arrival
from goalwire.errors import UnknownInterfaceError
from goalwire.records import record


@record
class _Wish:
    """The options of one `subscribe`."""

    throttle_s: float
    queue_length: int
    fragment_size: int | None
    compression: str


def _combine(wishes: Sequence[_Wish]) -> _Wish:
    """Return the options that serve all of a client's subscriptions to one topic, as the protocol says."""
    sizes = [wish.fragment_size for wish in wishes if wish.fragment_size is not None]
    ranks = ('none', 'png', 'cbor', 'cbor-raw')
    return _Wish(
        min(wish.throttle_s for wish in wishes),
        max(wish.queue_length for wish in wishes),
        min(sizes, default=None),
        max((wish.compression for wish in wishes), key=ranks.index),
    )


class Subscribing:
    """The topics to which one client has subscribed."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._subscriptions: dict[str, _Subscription] = {}
        self.operations = {'subscribe': self.subscribe, 'unsubscribe': self.unsubscribe}

    async def subscribe(self, operation: Operation) -> None:
        """Listen to a topic. The type may be left out if the topic is in the graph."""
        given = text_of(operation, 'topic')
        topic = full_name(given)
        hub = self._client.hub
        self._client.permissions.check_subscribe(topic)
        size = int(number_of(operation, 'fragment_size')) or None
        wish = _Wish(
            number_of(operation, 'throttle_rate') / 1000,
            int(number_of(operation, 'queue_length')),
            size,
            compression_of(operation),
        )
        there = dict(hub.node.graph.topics()).get(topic, [])
        type_name = operation.get('type') or await hub.type_of_topic(topic)
        full_type, cls = await hub.interfaces.find(str(type_name), 'msg')
        if there and full_type not in there:
            raise UnknownInterfaceError(
                f"the topic '{topic}' has the type {', '.join(there)}, not {full_type}"
            )
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            subscription = self._subscriptions[topic] = _Subscription(self._client, topic, given)
            subscription.stop = hub.feeds.listen(topic, full_type, cls, subscription)
        subscription.wishes[operation.get('id')] = wish
        subscription.adapt()

    async def unsubscribe(self, operation: Operation) -> None:
        """End one subscription to a topic, or all of them if no id is given."""
        topic = full_name(text_of(operation, 'topic'))
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            self._client.tell('warning', f"unsubscribe: '{topic}' is not subscribed to", operation)
            return
        if operation.get('id') is None:
            subscription.wishes.clear()
        subscription.wishes.pop(operation.get('id'), None)
        if subscription.wishes:
            subscription.adapt()
        else:
            self._subscriptions.pop(topic).close()

    def close(self) -> None:
        """Stop listening."""
        for subscription in self._subscriptions.values():
            subscription.close()
        self._subscriptions.clear()


class _Subscription:
    """A client's subscription to one topic: encodes and throttles messages, and puts them into the outbox."""

    def __init__(self, client: Client, topic: str, given: str) -> None:
        self._client = client
        self._topic = topic
        self._given = given
        """The topic's name as the client wrote it, because the client expects this name in the messages."""
        self.wishes: dict[object, _Wish] = {}
        self._wish = _Wish(0, 0, None, 'none')
        self._latest = float('-inf')
        self._waiting: deque[Arrival] = deque(maxlen=1)
        self._timer: asyncio.TimerHandle | None = None
        self.stop: Callable[[], None] = lambda: None

    def adapt(self) -> None:
        """Combine the options of the client's subscriptions again, after one has begun or ended."""
        self._wish = _combine(list(self.wishes.values()))
        self._waiting = deque(self._waiting, maxlen=max(1, self._wish.queue_length))

    def take(self, arrival: Arrival) -> None:
        """Send a message, at once or after the throttle's pause; a full queue drops its oldest message."""
        if not self._wish.throttle_s:
            self._send(arrival)
            return
        self._waiting.append(arrival)
        if self._timer is None:
            self._send_next()

    def _send_next(self) -> None:
        self._timer = None
        if not self._waiting:
            return
        left = self._latest + self._wish.throttle_s - monotonic()
        if left <= 0:
            self._latest = monotonic()
            self._send(self._waiting.popleft())
            left = self._wish.throttle_s
        if self._waiting:
            self._timer = asyncio.get_running_loop().call_later(left, self._send_next)

    def _send(self, arrival: Arrival) -> None:
        key = f'{self._wish.compression} {self._given}'
        packed: list[Frame] = arrival.form(key, self._pack)
        if self._wish.fragment_size is not None and isinstance(packed[0], str):
            packed = frames(packed[0], self._wish.fragment_size)
        self._client.outbox.put_of_topic(self._topic, packed, self._wish.queue_length)

    def _pack(self, arrival: Arrival) -> list[Frame]:
        head: dict[str, Any] = {'op': 'publish', 'topic': self._given}
        match self._wish.compression:
            case 'cbor':
                return [cbor(head | {'msg': arrival.form('cbor', lambda each: to_cbor(each.message))})]
            case 'cbor-raw':
                now = self._client.now()
                raw = {'secs': now.sec, 'nsecs': now.nanosec, 'bytes': arrival.data}
                return [cbor(head | {'msg': raw})]
        text: str = arrival.form('json', lambda each: json_text(to_json(each.message)))
        return frames(f'{json_text(head)[:-1]},"msg":{text}}}', None, self._wish.compression)

    def close(self) -> None:
        """Stop sending."""
        self.stop()
        if self._timer is not None:
            self._timer.cancel()
