"""Sessions, nodes and endpoints on DDS, as the graph and ros_discovery_info show them.

Both kinds of DDS session use this module. Subclasses of `DdsContext` and `EndpointFactory` contain the parts
that differ between libddsc and goalwire's own RTPS.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count
from typing import Generic, NamedTuple, TypeVar

from goalwire.concurrency.forks import ForkGuard
from goalwire.fault_reports import RejectCounters
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
)
from goalwire.transport.dds.announcement import Announcement
from goalwire.transport.dds.description import GUID_PREFIX_SIZE, service_id
from goalwire.transport.dds.environment import knows_its_peers
from goalwire.transport.dds.notifier import GraphNotifier
from goalwire.transport.endpoint import EndpointState, OpenNode, OpenPort, OpenSession, close_at_exit


class PublisherEnd(OpenPort, PublisherPort):
    """A publisher that is open until its state is closed."""


class ClientEnd(OpenPort, ClientPort):
    """A client that is open until its state is closed."""


P = TypeVar('P', bound=OpenPort)


class Made(NamedTuple, Generic[P]):
    """An endpoint that was just made, and the GUIDs of its readers and writers."""

    port: P
    readers: tuple[bytes, ...]
    writers: tuple[bytes, ...]
    begin: Callable[[], object] = bool
    """Starts the delivery of the endpoint's messages; called once the graph shows the endpoint."""


class DdsContext(ABC):
    """The common part of a session's endpoints, on libddsc or on goalwire's own RTPS."""

    notifier: GraphNotifier
    announcement: Announcement
    rejects: RejectCounters
    guard: ForkGuard

    def __init__(self, guid: bytes, domain_id: int, enclave: str) -> None:
        """`guid` is the GUID of the participant."""
        self.guid = guid
        self.id = guid.hex()
        self.domain_id = domain_id
        self.enclave = enclave
        self.next_id = count().__next__
        self._next_service = count(1).__next__

    def next_service_id(self) -> str:
        """Return a new id for the reader and writer of one client or server."""
        return service_id(self.guid, self._next_service())

    @abstractmethod
    def announce(self) -> None:
        """Publish the changes of `announcement`."""

    @abstractmethod
    def has_heard_all(self) -> bool:
        """Return whether all participants, known or on this machine, have announced everything."""

    @abstractmethod
    def close(self) -> None:
        """Leave the domain."""


class EndpointFactory(ABC):
    """Makes the endpoints of one session, and notes in `state` how to undo each step."""

    @abstractmethod
    def publisher(self, state: EndpointState, endpoint: Endpoint) -> Made[PublisherEnd]:
        """Make a publisher."""

    @abstractmethod
    def subscription(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Sample], None]
    ) -> Made[OpenPort]:
        """Make a subscription."""

    @abstractmethod
    def service(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Request], None]
    ) -> Made[OpenPort]:
        """Make a service server."""

    @abstractmethod
    def client(self, state: EndpointState, endpoint: Endpoint) -> Made[ClientEnd]:
        """Make a service client."""


class DdsNode(OpenNode):
    """A declared node and its endpoints."""

    def __init__(
        self, context: DdsContext, factory: EndpointFactory, name: NodeName, state: EndpointState
    ) -> None:
        self.id = context.next_id()
        super().__init__(state, context.guid[:GUID_PREFIX_SIZE] + self.id.to_bytes(4, 'big'))
        self._context = context
        self._factory = factory
        self._entity = GraphEntity(
            EndpointKind.NODE, context.id, self.id, replace(name, enclave=context.enclave), gid=self.gid
        )
        state.undo += [
            partial(context.notifier.change, [(False, self._entity)]),
            context.announce,
            partial(context.announcement.remove_node, self.id),
            self.ports.close,
        ]
        context.announcement.add_node(self.id, name)
        context.announce()
        context.notifier.change([(True, self._entity)])

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._opening(endpoint) as state:
            return self._show(self._factory.publisher(state, endpoint), endpoint)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._opening(endpoint) as state:
            return self._show(self._factory.subscription(state, endpoint, deliver), endpoint)

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._opening(endpoint) as state:
            return self._show(self._factory.service(state, endpoint, deliver), endpoint)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._opening(endpoint) as state:
            return self._show(self._factory.client(state, endpoint), endpoint)

    @contextmanager
    def _opening(self, endpoint: Endpoint) -> Iterator[EndpointState]:
        """Prepare an endpoint; if the block fails, its declarations are undone."""
        with self.ports.opening(f"{endpoint.kind.value} '{endpoint.name}'") as state:
            yield state

    def _show(self, made: Made[P], endpoint: Endpoint) -> P:
        """Show an endpoint in the graph, announce it to the others, and start its delivery."""
        context, (port, readers, writers, begin) = self._context, made
        entity = replace(
            self._entity,
            kind=endpoint.kind,
            name=endpoint.name,
            type_name=endpoint.type_name,
            type_hash=_choose_hash(endpoint),
            qos=endpoint.qos.stated(),
            gid=port.gid,
        )
        undo = port.state.undo
        undo.append(partial(context.notifier.change, [(False, entity)]))
        context.notifier.change([(True, entity)])
        context.announcement.add(self.id, readers, writers)
        undo += [context.announce, partial(context.announcement.remove, self.id, (*readers, *writers))]
        context.announce()
        begin()
        return self.ports.keep(port)


def _choose_hash(endpoint: Endpoint) -> str:
    """Return the hash for the graph: '' for services, since other participants do not announce theirs."""
    is_topic = endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
    return endpoint.type_hash if is_topic else ''


class DdsSession(OpenSession):
    """An open session and its nodes, on libddsc or on goalwire's own RTPS."""

    enforces_qos = True
    compares_definitions = False
    discovers_at_once = False

    def __init__(self, context: DdsContext, factory: EndpointFactory) -> None:
        super().__init__(context.domain_id, context.guard)
        self.id = context.id
        self._context = context
        self._factory = factory
        self.knows_its_peers = knows_its_peers()
        self.state.undo += [context.close, self.nodes.close]
        close_at_exit(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        with self.nodes.opening(f"node '{name.qualified}'", name.logger) as state:
            return self.nodes.keep(DdsNode(self._context, self._factory, name, state))

    def watch_graph(self, listener: GraphListener) -> None:
        """Report everything in the domain to `listener`, and every change."""
        self.state.check()
        self._context.notifier.watch(listener)

    def has_heard_all(self) -> bool:
        """Return whether all participants, known or on this machine, have announced everything."""
        return self._context.has_heard_all()

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._context.rejects.counts()
