"""The connection graph: the publishers, subscribers and servers of each topic and service."""

from __future__ import annotations

from typing import Any

from goalwire.apps.bridge.foxglove.client import Client, Fields
from goalwire.transport.contract import EndpointKind


class Connections:
    """Sends the connection graph, and then its changes, to a client that has subscribed to it."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._is_asked = False
        self._told: dict[EndpointKind, dict[str, list[str]]] = {}

    async def subscribe(self, _fields: Fields) -> None:
        """Send the connection graph now, and its changes from now on."""
        self._is_asked, self._told = True, {}
        self.update()

    async def unsubscribe(self, _fields: Fields) -> None:
        """Stop sending the connection graph."""
        self._is_asked = False

    def update(self) -> None:
        """Send the changes of the connection graph."""
        if not self._is_asked:
            return
        now = {
            kind: self._users(kind)
            for kind in (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION, EndpointKind.SERVICE)
        }
        before = {kind: self._told.get(kind, {}) for kind in now}
        topics = (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION)
        gone = {name for kind in topics for name in before[kind]} - {
            name for kind in topics for name in now[kind]
        }
        if now == self._told:
            return
        self._told = now
        self._client.send(
            'connectionGraphUpdate',
            publishedTopics=_find_changes(before, now, EndpointKind.PUBLISHER, 'publisherIds'),
            subscribedTopics=_find_changes(before, now, EndpointKind.SUBSCRIPTION, 'subscriberIds'),
            advertisedServices=_find_changes(before, now, EndpointKind.SERVICE, 'providerIds'),
            removedTopics=sorted(gone),
            removedServices=sorted(before[EndpointKind.SERVICE].keys() - now[EndpointKind.SERVICE].keys()),
        )

    def _users(self, kind: EndpointKind) -> dict[str, list[str]]:
        permissions = self._client.permissions
        is_seen = permissions.shows_service if kind is EndpointKind.SERVICE else permissions.shows_topic
        found: dict[str, set[str]] = {}
        for each in self._client.hub.node.graph.endpoints():
            if each.kind is kind and is_seen(each.name):
                found.setdefault(each.name, set()).add(each.node.qualified)
        return {name: sorted(nodes) for name, nodes in found.items()}


def _find_changes(
    before: dict[EndpointKind, dict[str, list[str]]],
    now: dict[EndpointKind, dict[str, list[str]]],
    kind: EndpointKind,
    users: str,
) -> list[dict[str, Any]]:
    """Return the names with changed users; the list of a name without users is empty."""
    names = before[kind].keys() | now[kind].keys()
    return [
        {'name': name, users: now[kind].get(name, [])}
        for name in sorted(names)
        if before[kind].get(name) != now[kind].get(name)
    ]
