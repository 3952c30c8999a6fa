"""Sessions of the memory transport: the contexts of one process, joined by a bus per domain id."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import count
from threading import Lock

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
from goalwire.transport.fork import ForkGuard
from goalwire.transport.members import Members
from goalwire.transport.memory.bus import BUSES, Bus, Watcher, key_of
from goalwire.transport.memory.port import Membership, describe, describe_node
from goalwire.transport.memory.services import MemoryClient, MemoryService
from goalwire.transport.memory.topics import MemoryPublisher, MemorySubscription
from goalwire.transport.place import Place


class MemorySession(Session):
    """One context on the bus of its domain."""

    def __init__(self, domain_id: int) -> None:
        self._domain_id = domain_id
        self._bus = BUSES.acquire(domain_id)
        self._guard = ForkGuard()
        gid_prefix = os.urandom(16)
        self.id = gid_prefix.hex()
        self._gid_prefix = gid_prefix[:8]
        self._numbers = count()
        self._place = Place(f'session of domain {domain_id}', self._guard, self._leave)
        self._nodes = Members(self._place)
        self._watchers: list[Watcher] = []
        self._lock = Lock()

    def _next_gid(self) -> tuple[int, bytes]:
        """Return a new number of this session and the gid made of both."""
        number = next(self._numbers)
        return number, self._gid_prefix + number.to_bytes(8, 'big')

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self._place.check()
        number, gid = self._next_gid()
        entity = describe_node(name, self.id, number, gid)
        node = MemoryNode(entity, self._bus, self._guard, lambda: self._next_gid()[1], self._nodes.forget)
        self._nodes.keep(node)
        self._bus.show(node.place)
        return node

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything on this bus."""
        self._place.check()
        watcher = self._bus.watch(listener)
        with self._lock:
            if not self._place.closed:
                self._watchers.append(watcher)
                return
        self._bus.unwatch(watcher)

    def silence(self) -> None:
        """Have publishers and clients send nothing more."""
        self._guard.silence()

    def close(self) -> None:
        """Close every node and leave the bus."""
        self._place.give_up()

    def _leave(self) -> None:
        with self._lock:
            watchers = list(self._watchers)
        for watcher in watchers:
            self._bus.unwatch(watcher)
        self._nodes.close()
        BUSES.release(self._domain_id)


class MemoryNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(
        self,
        entity: GraphEntity,
        bus: Bus,
        guard: ForkGuard,
        next_gid: Callable[[], bytes],
        forget: Callable[[bytes], None],
    ) -> None:
        self.gid = entity.gid
        self.place = Membership(entity, guard, self._leave)
        self._bus = bus
        self._guard = guard
        self._next_gid = next_gid
        self._forget = forget
        self._ports = Members(self.place)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        place = self._place_for(endpoint, lambda: self._bus.remove_publisher(port))
        port = MemoryPublisher(place)
        self._ports.keep(port)
        self._bus.add_publisher(port)
        return port

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        place = self._place_for(endpoint, lambda: self._bus.remove_subscription(port))
        port = MemorySubscription(place, deliver, ignore_local=endpoint.ignore_local)
        self._ports.keep(port)
        self._bus.add_subscription(port)
        return port

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        place = self._place_for(endpoint, lambda: self._bus.remove_server(port))
        port = MemoryService(place, deliver)
        self._ports.keep(port)
        self._bus.add_server(port)
        return port

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""

        def leave() -> None:
            self._bus.hide(place.entity)
            port.cancel_all()

        place = self._place_for(endpoint, leave)
        key = key_of(place.entity)
        port = MemoryClient(place, lambda: self._bus.servers(key))
        self._ports.keep(port)
        self._bus.show(place)
        return port

    def _place_for(self, endpoint: Endpoint, leave: Callable[[], None]) -> Membership:
        """Return the place of a new endpoint; `leave` takes it off the bus."""
        self.place.check()
        entity = describe(endpoint, self.place.entity, self._next_gid())

        def leave_us() -> None:
            self._ports.forget(entity.gid)
            leave()

        return Membership(entity, self._guard, leave_us)

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self.place.give_up()

    def _leave(self) -> None:
        self._ports.close()
        self._bus.hide(self.place.entity)
        self._forget(self.gid)


class MemoryTransport(Transport):
    """The wire within one process."""

    identifier = 'goalwire_memory'

    def open(self, options: SessionOptions) -> Session:
        """Join the bus of a domain; it exists as long as somebody is on it."""
        return MemorySession(options.domain_id)
