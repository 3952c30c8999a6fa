"""One context's session on DDS: a participant, and its nodes, which are announced in ros_discovery_info."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

from goalwire.concurrency.descriptors import require_free
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
    SessionOptions,
)
from goalwire.transport.dds.configuration import knows_its_peers
from goalwire.transport.dds.context import DdsContext, EndpointBuilder
from goalwire.transport.dds.library import load
from goalwire.transport.dds.services import DdsClient, DdsService
from goalwire.transport.dds.topics import DdsPublisher, DdsSubscription
from goalwire.transport.endpoint import Child, EndpointState, OpenNode, OpenSession, close_at_exit

C = TypeVar('C', bound=Child)


class DdsNode(OpenNode):
    """A declared node and its endpoints."""

    def __init__(self, context: DdsContext, name: NodeName, state: EndpointState) -> None:
        self.id = context.next_id()
        super().__init__(state, context.participant.guid[:12] + self.id.to_bytes(4, 'big'))
        self._context = context
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
        with self._opening(endpoint) as new:
            port = DdsPublisher(self._context, new, endpoint)
            return self._show(port, new, endpoint, (), (port.gid,))

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._opening(endpoint) as new:
            port = DdsSubscription(self._context, new, endpoint, deliver)
            return self._show(port, new, endpoint, (port.gid,), ())

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._opening(endpoint) as new:
            port = DdsService(self._context, new, endpoint, deliver)
            return self._show(port, new, endpoint, *port.gids)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._opening(endpoint) as new:
            port = DdsClient(self._context, new, endpoint)
            return self._show(port, new, endpoint, *port.gids)

    @contextmanager
    def _opening(self, endpoint: Endpoint) -> Iterator[EndpointBuilder]:
        """Prepare an endpoint; whatever was declared of it is undone where the block fails."""
        with self.ports.opening(f"{endpoint.kind.value} '{endpoint.name}'") as state:
            yield EndpointBuilder(self._context, state)

    def _show(
        self,
        port: C,
        new: EndpointBuilder,
        endpoint: Endpoint,
        readers: Iterable[bytes],
        writers: Iterable[bytes],
    ) -> C:
        """Show an endpoint in the graph, here and to the others, and let its messages in."""
        entity = replace(
            self._entity,
            kind=endpoint.kind,
            name=endpoint.name,
            type_name=endpoint.type_name,
            type_hash=_shown_hash(endpoint),
            qos=endpoint.qos.stated(),
            gid=port.gid,
        )
        new.undo.append(partial(self._context.notifier.change, [(False, entity)]))
        self._context.notifier.change([(True, entity)])
        new.show(self.id, readers, writers)
        return self.ports.keep(port)


def _shown_hash(endpoint: Endpoint) -> str:
    """A service's hash is not told to others, so it is not shown here either, where it could be compared."""
    is_topic = endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
    return endpoint.type_hash if is_topic else ''


def open_session(options: SessionOptions) -> DdsSession:
    """Join a domain. Raises TransportError or ForkedError."""
    require_free('a session on DDS')
    return DdsSession(DdsContext(load(), options.domain_id, options.enclave))


class DdsSession(OpenSession):
    """An open session and its nodes."""

    enforces_qos = True
    compares_definitions = False
    discovers_at_once = False

    def __init__(self, context: DdsContext) -> None:
        super().__init__(context.domain_id, context.guard)
        self.id = context.id
        self.wire_poller = context.wire_poller
        self._context = context
        self.knows_its_peers = knows_its_peers()
        self.state.undo += [context.close, self.nodes.close, context.participant.leave_at_once]
        close_at_exit(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        with self.nodes.opening(f"node '{name.qualified}'", name.logger) as state:
            return self.nodes.keep(DdsNode(self._context, name, state))

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything in the domain."""
        self.state.check()
        self._context.notifier.watch(listener)

    def has_heard_all(self) -> bool:
        """Whether all participants of this machine, and all that were met, have told what they have."""
        return self._context.discovery.has_heard_all()

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._context.rejects.counts()
