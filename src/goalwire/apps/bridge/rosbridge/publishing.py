"""The operations advertise, unadvertise and publish."""

from __future__ import annotations

from typing import Any

import goalwire
from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.rosbridge.client import Client, Operation, text_of
from goalwire.errors import UnknownInterfaceError
from goalwire.records import record
from goalwire.rules.qos import DurabilityPolicy, QoS


@record
class _Publisher:
    type_name: str
    cls: Any
    port: goalwire.Publisher[Any]


class Publishing:
    """The topics on which one client publishes; its publishers end when it disconnects."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._publishers: dict[str, _Publisher] = {}
        self._ids: dict[str, set[object]] = {}
        """By topic: the ids of the advertisements. The publisher ends with the last of them."""
        self.operations = {
            'advertise': self.advertise,
            'unadvertise': self.unadvertise,
            'publish': self.publish,
        }

    async def advertise(self, operation: Operation) -> None:
        """Make a publisher; `latch` makes it transient local."""
        topic = full_name(text_of(operation, 'topic'))
        await self._open(topic, text_of(operation, 'type'), operation)
        self._ids.setdefault(topic, set()).add(operation.get('id'))

    async def _open(self, topic: str, type_name: str, operation: Operation) -> _Publisher:
        hub = self._client.hub
        self._client.permissions.check_publish(topic)
        full_type, cls = await hub.interfaces.find(type_name, 'msg')
        known = self._publishers.get(topic)
        there = {types[0] for name, types in hub.node.graph.topics() if name == topic and len(types) == 1}
        if (known and known.type_name != full_type) or (there and full_type not in there):
            has = known.type_name if known else there.pop()
            raise UnknownInterfaceError(f"the topic '{topic}' has the type {has}, not {full_type}")
        if known is None:
            history = (
                DurabilityPolicy.TRANSIENT_LOCAL if operation.get('latch') else DurabilityPolicy.VOLATILE
            )
            depth = operation.get('queue_size')
            qos = QoS(depth=depth if type(depth) is int and 0 < depth <= 10_000 else 100, durability=history)
            known = _Publisher(full_type, cls, hub.node.publisher(cls, topic, qos=qos))
            self._publishers[topic] = known
        return known

    async def unadvertise(self, operation: Operation) -> None:
        """End an advertisement, or all advertisements of the topic if no id is given."""
        topic = full_name(text_of(operation, 'topic'))
        ids = self._ids.get(topic, set())
        if topic not in self._publishers:
            self._client.tell('warning', f"unadvertise: '{topic}' is not advertised", operation)
            return
        ids.discard(operation.get('id'))
        if not ids or operation.get('id') is None:
            self._ids.pop(topic, None)
            self._publishers.pop(topic).port.close()

    async def publish(self, operation: Operation) -> None:
        """Publish a message; if the topic is not advertised, advertise it with its type in the graph."""
        topic = full_name(text_of(operation, 'topic'))
        publisher = self._publishers.get(topic)
        if publisher is None:
            self._client.permissions.check_publish(topic)
            found = operation.get('type') or await self._client.hub.type_of_topic(topic)
            publisher = await self._open(topic, str(found), operation)
        self._client.permissions.check_message(topic)
        values = operation.get('msg', {})
        publisher.port.publish(self._client.message(publisher.cls, values, has_auto_header=True))

    def close(self) -> None:
        """End every publisher."""
        for publisher in self._publishers.values():
            publisher.port.close()
        self._publishers.clear()
