"""Wraps a transport, its sessions and nodes, and applies the faults of a plan to their packets."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock, RLock
from types import TracebackType
from typing import Self, TypeAlias

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.transport import wrappers
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
    Session,
    SessionOptions,
    Transport,
)
from goalwire.transport.faults.delay_queue import Clock
from goalwire.transport.faults.plan import AnyFault, Plan
from goalwire.transport.faults.ports import FaultyClient, FaultyPublisher, FaultyService, FaultySubscription
from goalwire.transport.graph_dispatcher import GraphDispatcher, graph_dispatcher

_Key: TypeAlias = tuple[EndpointKind, str, int, bytes]


def _key_of(entity: GraphEntity) -> _Key:
    return entity.kind, entity.session, entity.node_id, entity.gid


class FilteredGraph(GraphListener):
    """Stands between the wire's graph and its listener, and leaves out entities that are hidden.

    Changes that come from the wire and from the faults at the same time reach the listener in one order.
    Without a listener the entities are kept only to be queried.
    """

    def __init__(self, listener: GraphListener | None, is_hidden: Callable[[GraphEntity], bool]) -> None:
        self._is_hidden = is_hidden
        self._lock = RLock()
        self._entities: dict[_Key, GraphEntity] = {}
        self._hidden: set[_Key] = set()
        self._owners: dict[bytes, str] = {}
        self._dispatcher: GraphDispatcher = (
            OrderedDispatcher(lambda _: None) if listener is None else graph_dispatcher(listener)
        )

    def owner_of(self, gid: bytes) -> str:
        """Return the qualified name of the node that an endpoint belongs to, '' if it is unknown."""
        return self._owners.get(gid, '')

    def appeared(self, entity: GraphEntity) -> None:
        key = _key_of(entity)
        with self._lock:
            self._entities[key] = entity
            self._owners[entity.gid] = entity.node.qualified
            if self._is_hidden(entity):
                self._hidden.add(key)
            else:
                self._dispatcher.post((True, entity))
        self._dispatcher.drain()

    def vanished(self, entity: GraphEntity) -> None:
        key = _key_of(entity)
        with self._lock:
            self._entities.pop(key, None)
            self._owners.pop(entity.gid, None)
            if key in self._hidden:
                self._hidden.discard(key)
            else:
                self._dispatcher.post((False, entity))
        self._dispatcher.drain()

    def connected(self) -> None:
        self._dispatcher.post(None)
        self._dispatcher.drain()

    def look_again(self) -> None:
        """Hide and show entities again, since a partition has begun or ended."""
        with self._lock:
            for key, entity in self._entities.items():
                is_hidden = self._is_hidden(entity)
                if is_hidden != (key in self._hidden):
                    self._change(key, entity, is_hidden)
        self._dispatcher.drain()

    def _change(self, key: _Key, entity: GraphEntity, is_hidden: bool) -> None:
        if is_hidden:
            self._hidden.add(key)
            self._dispatcher.post((False, entity))
        else:
            self._hidden.discard(key)
            self._dispatcher.post((True, entity))

    def has_lost_servers(self, name: str) -> bool:
        """Return whether the service has servers, and all of them are hidden."""
        if not self._hidden:
            return False
        with self._lock:
            servers = [
                key
                for key, entity in self._entities.items()
                if entity.kind is EndpointKind.SERVICE and entity.name == name
            ]
            return bool(servers) and self._hidden.issuperset(servers)


class FaultySession(Session):
    """Wraps a session and puts the faults of a plan between it and its peers."""

    def __init__(self, inner: Session, faults: Plan) -> None:
        self.inner = inner
        self.faults = faults
        self.id = inner.id
        self.enforces_qos = inner.enforces_qos
        self.discovers_at_once = inner.discovers_at_once
        self.knows_its_peers = inner.knows_its_peers
        self.compares_definitions = inner.compares_definitions
        self.refusals = inner.refusals
        self.wire_poller = inner.wire_poller
        self._lock = Lock()
        self._nodes: tuple[FaultyNode, ...] = ()
        self.filtered_graph = FilteredGraph(None, self._is_hidden)
        self._graphs: tuple[FilteredGraph, ...] = (self.filtered_graph,)
        try:
            inner.watch_graph(self.filtered_graph)
        except BaseException:
            inner.close()
            raise
        faults.add_session(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self.faults.call('session.node')
        self.faults.revive(name.qualified)
        node = FaultyNode(self.inner.node(name), name.qualified, self)
        with self._lock:
            self._nodes += (node,)
        return node

    def has_heard_all(self) -> bool:
        """Return whether all known peers have announced everything."""
        return self.inner.has_heard_all()

    def watch_graph(self, listener: GraphListener) -> None:
        """Report to `listener` the part of the graph that the faults do not hide."""
        self.faults.call('session.watch_graph')
        filtered_graph = FilteredGraph(listener, self._is_hidden)
        with self._lock:
            self._graphs += (filtered_graph,)
        self.inner.watch_graph(filtered_graph)

    def silence(self) -> None:
        """Refuse to send from now on: publishers and clients raise ClosedError."""
        self.inner.silence()

    def close(self) -> None:
        """Undeclare everything and disconnect; packets under way to this session are lost."""
        self.inner.close()
        with self._lock:
            self._nodes = ()
        self.faults.remove_session(self)
        self.faults.call('session.close')

    def discard(self, node: FaultyNode) -> None:
        """Forget a node that was closed."""
        with self._lock:
            self._nodes = tuple(each for each in self._nodes if each is not node)

    def look_again(self) -> None:
        """Update the graph and end calls, since a partition may have changed."""
        for filtered_graph in self._graphs:
            filtered_graph.look_again()
        for node in self._nodes:
            node.look_again()

    def kill(self, name: str) -> None:
        """Remove a dead node's endpoints from the graph."""
        for node in self._nodes:
            if node.name == name:
                node.inner.close()

    def _is_hidden(self, entity: GraphEntity) -> bool:
        """Return whether partitions have cut the entity's node off from all nodes of this session."""
        nodes = self._nodes
        owner = entity.node.qualified
        return (
            bool(nodes)
            and entity.session != self.id
            and all(self.faults.parted(owner, node.name) for node in nodes)
        )


class FaultyNode(NodePort):
    """Wraps a node, and applies the faults of the plan to its endpoints."""

    def __init__(self, inner: NodePort, name: str, session: FaultySession) -> None:
        self.inner = inner
        self.gid = inner.gid
        self.name = name
        self._session = session
        self._faults = session.faults
        self._lock = Lock()
        self._clients: tuple[FaultyClient, ...] = ()

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        self._faults.call('node.publisher')
        return FaultyPublisher(self.inner.publisher(endpoint), endpoint.name, self.name, self._faults)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        self._faults.call('node.subscription')
        return FaultySubscription(
            lambda receive: self.inner.subscription(endpoint, receive),
            deliver, endpoint.name, self.name, self._faults, self._session.filtered_graph.owner_of,
        )  # fmt: skip

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        self._faults.call('node.service')
        return FaultyService(
            lambda receive: self.inner.service(endpoint, receive),
            deliver, endpoint.name, self.name, self._faults, self._session.filtered_graph.owner_of,
        )  # fmt: skip

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        self._faults.call('node.client')
        filtered_graph = self._session.filtered_graph
        client = FaultyClient(
            self.inner.client(endpoint), self._faults, lambda: filtered_graph.has_lost_servers(endpoint.name)
        )
        with self._lock:
            self._clients += (client,)
        return client

    def look_again(self) -> None:
        """End calls to servers that a partition has cut off."""
        for client in self._clients:
            client.look_again()

    def close(self) -> None:
        """Undeclare the node and its endpoints."""
        self.inner.close()
        self._session.discard(self)
        self._faults.call('node.close')


class Faults(Plan):
    """A plan that can be put on one transport by `over`, or on all transports by a `with` block."""

    def __init__(self, *faults: AnyFault, seed: int = 0, clock: Clock | None = None) -> None:
        self._switched_on: list[Callable[[], None]] = []
        super().__init__(*faults, seed=seed, clock=clock)

    def over(self, transport: Transport) -> Transport:
        """Return a transport whose sessions have these faults."""

        def open_with_faults(options: SessionOptions) -> Session:
            self.call('transport.open')
            return FaultySession(transport.open(options), self)

        return Transport(transport.identifier, open_with_faults)

    def __enter__(self) -> Self:
        """Put these faults on every session that this process opens from now on."""
        self._switched_on.append(wrappers.add(self.over))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._switched_on.pop()()
