"""The domains of this process: their endpoints, which of them match, and the listeners of the graph.

A domain's lock guards only the lists of its members. Nothing is delivered while it is held. A change posts
its deliveries to dispatchers, in the order of the changes, and they are drained once the lock is free.
"""

from __future__ import annotations

from collections import defaultdict
from threading import Lock
from typing import TypeAlias

from goalwire.transport.contract import GraphEntity, GraphListener
from goalwire.transport.endpoint import Shared
from goalwire.transport.graph_dispatcher import GraphDispatcher, graph_dispatcher
from goalwire.transport.memory.ports import MemoryPublisher, MemoryService, MemorySubscription

Key: TypeAlias = tuple[str, str, str]
"""Name, type and hash. Endpoints that share all three match, whatever their QoS (as in rmw_zenoh)."""


def key_of(entity: GraphEntity) -> Key:
    """Return the key by which endpoints are matched."""
    return entity.name, entity.type_name, entity.type_hash


class MemoryDomain:
    """The members of one domain."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._publishers: dict[Key, dict[bytes, MemoryPublisher]] = defaultdict(dict)
        self._subscriptions: dict[Key, dict[bytes, MemorySubscription]] = defaultdict(dict)
        self._servers: dict[Key, tuple[MemoryService, ...]] = {}
        self._entities: dict[bytes, GraphEntity] = {}
        self._watchers: tuple[GraphDispatcher, ...] = ()

    # Endpoints ------------------------------------------------------------

    def add_publisher(self, publisher: MemoryPublisher) -> None:
        """Add a publisher, and connect it with the matching subscriptions."""
        key = key_of(publisher.entity)
        with self._lock:
            self._publishers[key][publisher.gid] = publisher
            for subscription in self._subscriptions.get(key, {}).values():
                if subscription.wants(publisher):
                    publisher.connect(subscription)
            watchers = self._note(publisher.entity)
        self._drain(watchers)

    def remove_publisher(self, publisher: MemoryPublisher) -> None:
        """Remove a publisher from the domain."""
        key = key_of(publisher.entity)
        with self._lock:
            _discard_from(self._publishers, key, publisher.gid)
            watchers = self._discard_entity(publisher.entity)
        self._drain(watchers)

    def add_subscription(self, subscription: MemorySubscription) -> None:
        """Add a subscription, and connect it with the matching publishers, which send it their history."""
        key = key_of(subscription.entity)
        with self._lock:
            self._subscriptions[key][subscription.gid] = subscription
            publishers = [each for each in self._publishers.get(key, {}).values() if subscription.wants(each)]
            for publisher in publishers:
                publisher.connect(subscription)
            watchers = self._note(subscription.entity)
        for publisher in publishers:
            publisher.flush()
        self._drain(watchers)

    def remove_subscription(self, subscription: MemorySubscription) -> None:
        """Remove a subscription from the domain."""
        key = key_of(subscription.entity)
        with self._lock:
            _discard_from(self._subscriptions, key, subscription.gid)
            for publisher in self._publishers.get(key, {}).values():
                publisher.disconnect(subscription)
            watchers = self._discard_entity(subscription.entity)
        self._drain(watchers)

    def add_server(self, server: MemoryService) -> None:
        """Add a server. It receives the calls that are made from now on."""
        key = key_of(server.entity)
        with self._lock:
            self._servers[key] = (*self._servers.get(key, ()), server)
            watchers = self._note(server.entity)
        self._drain(watchers)

    def remove_server(self, server: MemoryService) -> None:
        """Remove a server, and end the calls that it has not answered."""
        key = key_of(server.entity)
        with self._lock:
            others = tuple(each for each in self._servers.get(key, ()) if each is not server)
            if others:
                self._servers[key] = others
            else:
                self._servers.pop(key, None)
            watchers = self._discard_entity(server.entity)
        self._drain(watchers)
        server.cancel_all()

    def servers(self, key: Key) -> tuple[MemoryService, ...]:
        """Return the servers that a call reaches now."""
        with self._lock:
            return self._servers.get(key, ())

    # The graph ------------------------------------------------------------

    def show(self, entity: GraphEntity) -> None:
        """Add a node or a client to the graph. Nodes and clients are not connected with other endpoints."""
        with self._lock:
            watchers = self._note(entity)
        self._drain(watchers)

    def hide(self, entity: GraphEntity) -> None:
        """Remove a node or a client from the graph."""
        with self._lock:
            watchers = self._discard_entity(entity)
        self._drain(watchers)

    def watch(self, listener: GraphListener) -> GraphDispatcher:
        """Report the whole graph to a listener before this returns, and then every change."""
        watcher = graph_dispatcher(listener)
        with watcher.first_turn(), self._lock:
            for entity in self._entities.values():
                watcher.post((True, entity))
            self._watchers += (watcher,)
        return watcher

    def unwatch(self, watcher: GraphDispatcher) -> None:
        """Remove a listener."""
        with self._lock:
            self._watchers = tuple(each for each in self._watchers if each is not watcher)

    def _note(self, entity: GraphEntity) -> tuple[GraphDispatcher, ...]:
        self._entities[entity.gid] = entity
        return self._post(is_there=True, entity=entity)

    def _discard_entity(self, entity: GraphEntity) -> tuple[GraphDispatcher, ...]:
        if self._entities.pop(entity.gid, None) is None:
            return ()
        return self._post(is_there=False, entity=entity)

    def _post(self, *, is_there: bool, entity: GraphEntity) -> tuple[GraphDispatcher, ...]:
        for watcher in self._watchers:
            watcher.post((is_there, entity))
        return self._watchers

    @staticmethod
    def _drain(watchers: tuple[GraphDispatcher, ...]) -> None:
        for watcher in watchers:
            watcher.drain()


def _discard_from(
    table: dict[Key, dict[bytes, MemoryPublisher]] | dict[Key, dict[bytes, MemorySubscription]],
    key: Key,
    gid: bytes,
) -> None:
    """Remove one member and, if it was the last, its key."""
    children = table.get(key)
    if children is None:
        return
    children.pop(gid, None)
    if not children:
        del table[key]


DOMAINS: Shared[int, MemoryDomain] = Shared()
"""The domains that sessions of this process are in, by domain id."""
