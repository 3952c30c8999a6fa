"""A transport, its sessions and nodes, with the faults of a plan between them and the wire."""

from __future__ import annotations

from collections.abc import Callable
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
from goalwire.transport.faults.client import FaultyClient
from goalwire.transport.faults.filtered_graph import FilteredGraph, Nobody
from goalwire.transport.faults.plan import Faults
from goalwire.transport.faults.service import FaultyService
from goalwire.transport.faults.topics import FaultyPublisher, FaultySubscription


class FaultyTransport(Transport):
    """A kind of wire, with faults."""

    def __init__(self, inner: Transport, faults: Faults) -> None:
        self.identifier = inner.identifier
        self._inner = inner
        self._faults = faults

    def open(self, options: SessionOptions) -> Session:
        """Connect."""
        self._faults.call('transport.open')
        return FaultySession(self._inner.open(options), self._faults)


class FaultySession(Session):
    """A session, with faults."""

    def __init__(self, inner: Session, faults: Faults) -> None:
        self.inner = inner
        self.faults = faults
        self.id = inner.id
        self.enforces_qos = inner.enforces_qos
        self.discovers_at_once = inner.discovers_at_once
        self.compares_definitions = inner.compares_definitions
        self.wire_poller = inner.wire_poller
        self._lock = Lock()
        self._nodes: tuple[FaultyNode, ...] = ()
        self.filtered_graph = FilteredGraph(Nobody(), self._is_hidden)
        self._sights: tuple[FilteredGraph, ...] = (self.filtered_graph,)
        try:
            inner.watch_graph(self.filtered_graph)
        except BaseException:
            inner.close()
            raise
        faults.opened(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self.faults.call('session.node')
        self.faults.revive(name.qualified)
        node = FaultyNode(self.inner.node(name), name.qualified, self)
        with self._lock:
            self._nodes += (node,)
        return node

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of what can be seen in spite of the faults."""
        self.faults.call('session.watch_graph')
        filtered_graph = FilteredGraph(listener, self._is_hidden)
        with self._lock:
            self._sights += (filtered_graph,)
        self.inner.watch_graph(filtered_graph)

    def silence(self) -> None:
        """Have publishers and clients send nothing more."""
        self.inner.silence()

    def close(self) -> None:
        """Undeclare everything and disconnect; what is under way to this session is lost."""
        self.inner.close()
        with self._lock:
            self._nodes = ()
        self.faults.closed(self)
        self.faults.call('session.close')

    def drop(self, node: FaultyNode) -> None:
        """A node has been closed."""
        with self._lock:
            self._nodes = tuple(each for each in self._nodes if each is not node)

    def look_again(self) -> None:
        """What is parted may have changed."""
        for filtered_graph in self._sights:
            filtered_graph.look_again()
        for node in self._nodes:
            node.look_again()

    def kill(self, name: str) -> None:
        """Let a dead node's endpoints vanish from the graph."""
        for node in self._nodes:
            if node.name == name:
                node.inner.close()

    def _is_hidden(self, entity: GraphEntity) -> bool:
        """Whether none of this session's nodes hears anything of the entity's, and has noticed."""
        nodes = self._nodes
        owner = entity.node.qualified
        return (
            bool(nodes)
            and entity.session != self.id
            and all(self.faults.parted(owner, node.name) for node in nodes)
        )


class FaultyNode(NodePort):
    """A node, with faults."""

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
        """What is parted may have changed: calls to servers that have gone out of sight end."""
        for client in self._clients:
            client.look_again()

    def close(self) -> None:
        """Undeclare the node and its endpoints."""
        self.inner.close()
        self._session.drop(self)
        self._faults.call('node.close')
