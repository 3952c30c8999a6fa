"""Sessions and nodes of the memory transport: the contexts of one process that are in one domain."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count
from threading import Lock

from goalwire.concurrency.forks import ForkGuard
from goalwire.records import replace
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    EndpointKind,
    GraphEntity,
    GraphListener,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
    Transport,
)
from goalwire.transport.endpoint import EndpointState, OpenNode, OpenSession
from goalwire.transport.graph_dispatcher import GraphDispatcher
from goalwire.transport.memory.domain import DOMAINS, MemoryDomain, key_of
from goalwire.transport.memory.ports import MemoryClient, MemoryPublisher, MemoryService, MemorySubscription


class MemorySession(OpenSession):
    """One context in its domain."""

    def __init__(self, domain_id: int) -> None:
        super().__init__(domain_id, ForkGuard())
        gid_prefix = os.urandom(16)
        self.id = gid_prefix.hex()
        self._gid_prefix = gid_prefix[:8]
        self._numbers = count()
        self._domain = DOMAINS.open(domain_id, MemoryDomain)
        self._watchers: list[GraphDispatcher] = []
        self._lock = Lock()
        self.state.undo += [partial(DOMAINS.close, domain_id), self.nodes.close, self._unwatch_all]

    def next_gid(self) -> tuple[int, bytes]:
        """Return a new number in this session, and the gid for it."""
        number = next(self._numbers)
        return number, self._gid_prefix + number.to_bytes(8, 'big')

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        with self.nodes.opening(f"node '{name.qualified}'", name.logger) as state:
            number, gid = self.next_gid()
            entity = GraphEntity(EndpointKind.NODE, self.id, number, name, gid=gid)
            node = MemoryNode(state, entity, self._domain, self.next_gid)
            return self.nodes.keep(node)

    def watch_graph(self, listener: GraphListener) -> None:
        """Report everything in this domain to `listener`, and every change."""
        self.state.check()
        watcher = self._domain.watch(listener)
        with self._lock:
            if not self.state.closed:
                self._watchers.append(watcher)
                return
        self._domain.unwatch(watcher)

    def _unwatch_all(self) -> None:
        with self._lock:
            watchers = list(self._watchers)
        for watcher in watchers:
            self._domain.unwatch(watcher)


class MemoryNode(OpenNode):
    """A declared node and its endpoints."""

    def __init__(
        self,
        state: EndpointState,
        entity: GraphEntity,
        domain: MemoryDomain,
        next_gid: Callable[[], tuple[int, bytes]],
    ) -> None:
        super().__init__(state, entity.gid)
        self._entity = entity
        self._domain = domain
        self._next_gid = next_gid
        state.undo += [partial(domain.hide, entity), self.ports.close]
        domain.show(entity)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._opening(endpoint) as (state, entity):
            port = MemoryPublisher(state, entity)
            state.undo.append(partial(self._domain.remove_publisher, port))
            self._domain.add_publisher(port)
            return self.ports.keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._opening(endpoint) as (state, entity):
            port = MemorySubscription(state, entity, deliver, ignore_local=endpoint.ignore_local)
            state.undo.append(partial(self._domain.remove_subscription, port))
            self._domain.add_subscription(port)
            return self.ports.keep(port)

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._opening(endpoint) as (state, entity):
            port = MemoryService(state, entity, deliver)
            state.undo.append(partial(self._domain.remove_server, port))
            self._domain.add_server(port)
            return self.ports.keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._opening(endpoint) as (state, entity):
            port = MemoryClient(state, entity, partial(self._domain.servers, key_of(entity)))
            state.undo += [port.close_calls, partial(self._domain.hide, entity)]
            self._domain.show(entity)
            return self.ports.keep(port)

    @contextmanager
    def _opening(self, endpoint: Endpoint) -> Iterator[tuple[EndpointState, GraphEntity]]:
        """Prepare an endpoint and its entry in the graph; if the block fails, everything is undone."""
        entity = replace(
            self._entity,
            kind=endpoint.kind,
            name=endpoint.name,
            type_name=endpoint.type_name,
            type_hash=endpoint.type_hash,
            qos=endpoint.qos.stated(),
            gid=self._next_gid()[1],
        )
        title = f"{endpoint.kind.value} '{endpoint.name}' of node '{entity.node.qualified}'"
        with self.ports.opening(title) as state:
            yield state, entity


TRANSPORT = Transport('goalwire_memory', lambda options: MemorySession(options.domain_id))
"""The transport within one process. A domain exists as long as a session is in it."""
