"""Sends the recorded requests of a bag to live servers, instead of publishing their events."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from typing import Any

from goalwire.aio import Client, Node
from goalwire.apps.bag.selection import service_of
from goalwire.errors import CallError, DecodeError
from goalwire.idl import get_service
from goalwire.rosbag2.model import Message, Topic
from goalwire.rosbag2.types import decoder_of

ANSWER_S = 10.0
"""Seconds that an answer may take; playing does not wait for it."""
STEPS = {'service_introspection': 1, 'client_introspection': 0}
"""The event type of a request as its server, or its client, publishes it (service_msgs/msg/ServiceEventInfo).
"""


class ServiceRequests:
    """Calls services with the requests in recorded service events. Only for the loop's thread."""

    def __init__(self, node: Node, topics: Iterable[Topic], source: str) -> None:
        """Make the clients; raises InterfaceError for a service whose type is unknown here."""
        self._node = node
        self._step = STEPS[source]
        self._decoders: dict[str, Any] = {}
        self._clients: dict[str, Client[Any, Any]] = {}
        self._calls: set[asyncio.Task[None]] = set()
        self.sent = 0
        """How many requests were sent."""
        for topic in topics:
            service = service_of(topic.name)
            self._decoders[topic.name] = decoder_of(topic)
            kind = get_service(topic.type_name.removesuffix('_Event'))
            self._clients[topic.name] = node.client(kind, service)

    def send(self, message: Message) -> None:
        """Send the request in an event.

        Events of the side (server or client) that was not chosen, and events without contents, are ignored.
        """
        try:
            event = self._decoders[message.topic](message.data)
        except DecodeError as error:
            self._node.logger.warning(f"an event on '{message.topic}' cannot be read: {error}")
            return
        if event.info.event_type == self._step and event.request:
            call = asyncio.create_task(self._call(self._clients[message.topic], event.request[0]))
            self._calls.add(call)
            call.add_done_callback(self._calls.discard)
            self.sent += 1

    async def _call(self, client: Client[Any, Any], request: Any) -> None:
        try:
            await client.call(request, timeout=ANSWER_S)
        except CallError as error:
            self._node.logger.warning(str(error))

    async def finish(self) -> None:
        """Wait for the outstanding answers."""
        if self._calls:
            await asyncio.wait(self._calls)

    async def wait_for_servers(self, limit: float) -> None:
        """Wait until all servers have appeared, or `limit` s have passed."""
        waits = [client.wait_for_server(timeout=limit) for client in self._clients.values()]
        await asyncio.gather(*waits, return_exceptions=True)
