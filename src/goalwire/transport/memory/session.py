"""Sessions of the memory transport: the contexts of one process, joined by a bus per domain id."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import count
from threading import Lock

from goalwire.transport.children import Children
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    GraphEntity,
    GraphListener,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
    Session,
    SessionOptions,
    Transport,
)
from goalwire.transport.endpoint_state import EndpointState
from goalwire.transport.fork import ForkGuard
from goalwire.transport.memory.domain import DOMAINS, MemoryDomain, Watcher, key_of
from goalwire.transport.memory.endpoint_state import MemoryEndpointState, describe, describe_node
from goalwire.transport.memory.services import MemoryClient, MemoryService
from goalwire.transport.memory.topics import MemoryPublisher, MemorySubscription


class MemorySession(Session):
    """One context on the bus of its domain."""

    def __init__(self, domain_id: int) -> None:
        self._domain_id = domain_id
        self._domain = DOMAINS.acquire(domain_id)
        self._guard = ForkGuard()
        gid_prefix = os.urandom(16)
        self.id = gid_prefix.hex()
        self._gid_prefix = gid_prefix[:8]
        self._numbers = count()
        self._state = EndpointState(f'session of domain {domain_id}', self._guard, self._leave)
        self._nodes = Children(self._state)
        self._watchers: list[Watcher] = []
        self._lock = Lock()

    def _next_gid(self) -> tuple[int, bytes]:
        """Return a new number of this session and the gid made of both."""
        number = next(self._numbers)
        return number, self._gid_prefix + number.to_bytes(8, 'big')

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self._state.check()
        number, gid = self._next_gid()
        entity = describe_node(name, self.id, number, gid)
        node = MemoryNode(entity, self._domain, self._guard, lambda: self._next_gid()[1], self._nodes.forget)
        self._nodes.keep(node)
        self._domain.show(node.state)
        return node

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything on this bus."""
        self._state.check()
        watcher = self._domain.watch(listener)
        with self._lock:
            if not self._state.closed:
                self._watchers.append(watcher)
                return
        self._domain.unwatch(watcher)

    def silence(self) -> None:
        """Have publishers and clients send nothing more."""
        self._guard.silence()

    def close(self) -> None:
        """Close every node and leave the bus."""
        self._state.close()

    def _leave(self) -> None:
        with self._lock:
            watchers = list(self._watchers)
        for watcher in watchers:
            self._domain.unwatch(watcher)
        self._nodes.close()
        DOMAINS.release(self._domain_id)


class MemoryNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(
        self,
        entity: GraphEntity,
        domain: MemoryDomain,
        guard: ForkGuard,
        next_gid: Callable[[], bytes],
        forget: Callable[[bytes], None],
    ) -> None:
        self.gid = entity.gid
        self.state = MemoryEndpointState(entity, guard, self._leave)
        self._domain = domain
        self._guard = guard
        self._next_gid = next_gid
        self._forget = forget
        self._ports = Children(self.state)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        state = self._place_for(endpoint, lambda: self._domain.remove_publisher(port))
        port = MemoryPublisher(state)
        self._ports.keep(port)
        self._domain.add_publisher(port)
        return port

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        state = self._place_for(endpoint, lambda: self._domain.remove_subscription(port))
        port = MemorySubscription(state, deliver, ignore_local=endpoint.ignore_local)
        self._ports.keep(port)
        self._domain.add_subscription(port)
        return port

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        state = self._place_for(endpoint, lambda: self._domain.remove_server(port))
        port = MemoryService(state, deliver)
        self._ports.keep(port)
        self._domain.add_server(port)
        return port

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""

        def leave() -> None:
            self._domain.hide(state.entity)
            port.close_calls()

        state = self._place_for(endpoint, leave)
        key = key_of(state.entity)
        port = MemoryClient(state, lambda: self._domain.servers(key))
        self._ports.keep(port)
        self._domain.show(state)
        return port

    def _place_for(self, endpoint: Endpoint, leave: Callable[[], None]) -> MemoryEndpointState:
        """Return the place of a new endpoint; `leave` takes it off the bus."""
        self.state.check()
        entity = describe(endpoint, self.state.entity, self._next_gid())

        def leave_us() -> None:
            self._ports.forget(entity.gid)
            leave()

        return MemoryEndpointState(entity, self._guard, leave_us)

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self.state.close()

    def _leave(self) -> None:
        self._ports.close()
        self._domain.hide(self.state.entity)
        self._forget(self.gid)


class MemoryTransport(Transport):
    """The wire within one process."""

    identifier = 'goalwire_memory'

    def open(self, options: SessionOptions) -> Session:
        """Join the bus of a domain; it exists as long as somebody is on it."""
        return MemorySession(options.domain_id)
