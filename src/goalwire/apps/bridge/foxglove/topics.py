"""Channels: the topics that a client may subscribe to, and those on which it publishes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Any

from goalwire.aio.raw import RawPublisher
from goalwire.apps.bridge.foxglove import frames
from goalwire.apps.bridge.foxglove.client import (
    BadFieldError,
    Client,
    Fields,
    numbers_of,
    objects_of,
)
from goalwire.apps.bridge.foxglove.type_requests import TypeRequests
from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.outbox import Frame
from goalwire.apps.bridge.topic_feeds import Arrival
from goalwire.cdr import codec
from goalwire.graph.names import is_part_of_action
from goalwire.records import record
from goalwire.rosbag2.definitions import schema_of
from goalwire.rules.names.validation import is_hidden_name


@record
class Channel:
    """A channel: a topic of one type."""

    topic: str
    type_name: str


class ShownTopics:
    """Every topic of the graph that the client may see, including feedback and status of actions."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._numbers = count(1)
        self._channels: dict[Channel, int] = {}
        self._requests = TypeRequests(client, self.update)
        self._subscriptions: dict[int, _Subscription] = {}

    def update(self) -> None:
        """Send the client the new and the removed topics."""
        there = {
            Channel(topic, type_name)
            for topic, types in self._client.hub.node.graph.topics()
            if self._client.permissions.shows_topic(topic)
            and (is_part_of_action(topic) or not is_hidden_name(topic))
            for type_name in types
        }
        gone = [each for each in self._channels if each not in there]
        if gone:
            self._client.send('unadvertise', channelIds=[self._channels.pop(each) for each in gone])
        new = [self._description(each) for each in there if each not in self._channels]
        if shown := [each for each in new if each]:
            self._client.send('advertise', channels=shown)

    def _description(self, channel: Channel) -> dict[str, Any] | None:
        schema, _ = schema_of(channel.type_name)
        if not schema.encoding:
            self._requests.ask_for(channel.type_name)
            return None
        number = self._channels[channel] = next(self._numbers)
        return {
            'id': number,
            'topic': channel.topic,
            'encoding': frames.ENCODING,
            'schemaName': channel.type_name,
            'schema': schema.text,
            'schemaEncoding': schema.encoding,
        }

    async def subscribe(self, fields: Fields) -> None:
        """Begin subscriptions, whose ids the client chooses."""
        by_number = {number: channel for channel, number in self._channels.items()}
        for each in objects_of(fields, 'subscriptions'):
            name, channel = each.get('id'), by_number.get(each.get('channelId', -1))
            if type(name) is not int or not 0 <= name < 2**32 or name in self._subscriptions:
                raise BadFieldError(f"a subscription needs an 'id' of its own, not {name}")
            if channel is None:
                raise BadFieldError(f'there is no channel {each.get("channelId")}')
            self._client.permissions.check_subscribe(channel.topic)
            subscription = self._subscriptions[name] = _Subscription(self._client, name, channel.topic)
            feeds = self._client.hub.feeds
            subscription.stop = feeds.listen(channel.topic, channel.type_name, None, subscription)

    async def unsubscribe(self, fields: Fields) -> None:
        """End subscriptions."""
        for name in numbers_of(fields, 'subscriptionIds'):
            found = self._subscriptions.pop(name, None)
            if found is not None:
                found.stop()

    def close(self) -> None:
        """End every subscription."""
        for subscription in self._subscriptions.values():
            subscription.stop()
        self._subscriptions.clear()


class _Subscription:
    def __init__(self, client: Client, number: int, topic: str) -> None:
        self._client = client
        self._number = number
        self._topic = topic
        self.stop: Callable[[], None] = lambda: None

    def take(self, arrival: Arrival) -> None:
        """Send a message without decoding it."""
        frame: list[Frame] = [frames.message(self._number, arrival.time, arrival.data)]
        self._client.outbox.put_of_topic(self._topic, frame)


@record
class _ClientChannel:
    topic: str
    cls: Any
    port: RawPublisher


class PublishedTopics:
    """Channels that the client advertises; they end when it disconnects."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._channels: dict[int, _ClientChannel] = {}

    async def advertise(self, fields: Fields) -> None:
        """Make publishers."""
        hub = self._client.hub
        for each in objects_of(fields, 'channels'):
            name = each.get('id')
            if type(name) is not int or name in self._channels:
                raise BadFieldError(f"a channel needs an 'id' of its own, not {name}")
            if each.get('encoding') != frames.ENCODING:
                raise BadFieldError(f"the encoding must be '{frames.ENCODING}', not '{each.get('encoding')}'")
            topic = full_name(str(each.get('topic')))
            self._client.permissions.check_publish(topic)
            type_name, cls = await hub.interfaces.find(str(each.get('schemaName')), 'msg')
            there = dict(hub.node.graph.topics()).get(topic, [type_name])
            if type_name not in there:
                raise BadFieldError(f"the topic '{topic}' has the type {', '.join(there)}, not {type_name}")
            self._channels[name] = _ClientChannel(topic, cls, hub.node.raw_publisher(topic, type_name))

    async def unadvertise(self, fields: Fields) -> None:
        """End publishers."""
        for name in numbers_of(fields, 'channelIds'):
            channel = self._channels.pop(name, None)
            if channel is not None:
                channel.port.close()

    def publish(self, message: frames.ClientMessage) -> None:
        """Publish a serialized message. Raises DecodeError if the bytes are not of the channel's type."""
        channel = self._channels.get(message.channel)
        if channel is None:
            raise BadFieldError(f'there is no channel {message.channel} of this client')
        self._client.permissions.check_message(channel.topic)
        codec.decode(message.data, channel.cls)  # Nothing else checks the bytes of a client.
        channel.port.publish(message.data)

    def close(self) -> None:
        """End every publisher."""
        for channel in self._channels.values():
            channel.port.close()
        self._channels.clear()
