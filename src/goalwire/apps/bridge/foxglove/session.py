"""One client of Foxglove's protocol: shows it the graph, and carries out its operations."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

from rosgraph_msgs.msg import Clock

from goalwire.apps.bridge.foxglove import frames
from goalwire.apps.bridge.foxglove.assets import NoAssetError, read_asset
from goalwire.apps.bridge.foxglove.client import Client, Fields
from goalwire.apps.bridge.foxglove.connections import Connections
from goalwire.apps.bridge.foxglove.parameters import Parameters
from goalwire.apps.bridge.foxglove.services import Services
from goalwire.apps.bridge.foxglove.topics import PublishedTopics, ShownTopics
from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Frame, Outbox
from goalwire.apps.bridge.permissions import Permissions
from goalwire.apps.bridge.topic_feeds import Arrival
from goalwire.errors import GoalwireError, peer_text

_TOGETHER_S = 0.1
"""Seconds for which changes of the graph are collected, because a starting program causes many."""


class FoxgloveSession:
    """One client of the Foxglove protocol; a Session for the server."""

    def __init__(self, hub: Hub, outbox: Outbox, permissions: Permissions) -> None:
        self._client = client = Client(hub, outbox, permissions)
        self._topics = topics = ShownTopics(client)
        self._published = published = PublishedTopics(client)
        self._services = Services(client)
        self._parameters = parameters = Parameters(client)
        self._connections = connections = Connections(client)
        self._operations: dict[str, Callable[[Fields], Awaitable[None]]] = {
            'subscribe': topics.subscribe,
            'unsubscribe': topics.unsubscribe,
            'advertise': published.advertise,
            'unadvertise': published.unadvertise,
            'getParameters': parameters.get,
            'setParameters': parameters.set,
            'subscribeParameterUpdates': parameters.follow,
            'unsubscribeParameterUpdates': parameters.unfollow,
            'subscribeConnectionGraph': connections.subscribe,
            'unsubscribeConnectionGraph': connections.unsubscribe,
            'fetchAsset': self._fetch_asset,
        }
        self._stop_clock: Callable[[], None] = lambda: None
        self._greet()
        client.start(self._follow_graph())

    def _greet(self) -> None:
        hub = self._client.hub
        may_change = not self._client.permissions.read_only
        capabilities = ['parameters', 'parametersSubscribe', 'connectionGraph', 'assets']
        if may_change:
            capabilities += ['clientPublish', 'services']
        if hub.node.graph.publishers('/clock'):
            capabilities.append('time')
            self._stop_clock = hub.feeds.listen('/clock', 'rosgraph_msgs/msg/Clock', Clock, self)
        self._client.send(
            'serverInfo',
            name='goalwire',
            capabilities=capabilities,
            supportedEncodings=[frames.ENCODING],
            metadata={},
            sessionId=str(id(hub)),
        )

    async def _follow_graph(self) -> None:
        changes = self._client.hub.node.graph.changes()
        try:
            while True:
                self._topics.update()
                self._services.update()
                self._connections.update()
                await anext(changes)
                await asyncio.sleep(_TOGETHER_S)
        finally:
            changes.close()

    def take(self, arrival: Arrival) -> None:
        """Send simulated time to the client."""
        stamp = arrival.message.clock
        self._client.outbox.put_of_topic('/clock', [frames.time(stamp.sec * 10**9 + stamp.nanosec)], most=1)

    async def receive(self, frame: Frame) -> None:
        """Carry out one operation. A status tells the client of any error."""
        try:
            if isinstance(frame, bytes):
                self._receive_bytes(frame)
            else:
                await self._receive_text(frame)
        except RecursionError:
            self._client.tell('that is nested too deeply')
        except (GoalwireError, ValueError, TypeError) as error:
            self._client.tell(str(error))

    def _receive_bytes(self, frame: bytes) -> None:
        found = frames.read(frame)
        if isinstance(found, frames.ClientMessage):
            self._published.publish(found)
        else:
            self._services.call(found)

    async def _receive_text(self, frame: str) -> None:
        fields: Any = json.loads(frame)
        name = fields.get('op') if isinstance(fields, dict) else None
        carry = self._operations.get(name) if isinstance(name, str) else None
        if carry is None:
            self._client.tell(f"there is no operation '{peer_text(name, 100)}'")
        else:
            await carry(fields)

    async def _fetch_asset(self, fields: Fields) -> None:
        number = fields.get('requestId')
        if type(number) is not int or not 0 <= number < 2**32:
            raise NoAssetError("fetchAsset: 'requestId' must be a number")
        self._client.start(self._send_asset(number, str(fields.get('uri'))))

    async def _send_asset(self, number: int, uri: str) -> None:
        try:
            frame = frames.asset(number, await asyncio.to_thread(read_asset, uri))
        except NoAssetError as error:
            frame = frames.asset(number, b'', str(error))
        self._client.outbox.put([frame])

    async def close(self) -> None:
        """End the client's calls and subscriptions. Its goals are cancelled, unless the bridge keeps them."""
        self._stop_clock()
        self._topics.close()
        self._published.close()
        self._parameters.close()
        await self._client.end_tasks()
        if not self._client.hub.settings.keeps_goals:
            await self._services.cancel_goals()
