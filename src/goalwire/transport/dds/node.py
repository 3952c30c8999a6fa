"""Nodes: part of ros_discovery_info, and the endpoints declared through them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from goalwire.records import replace
from goalwire.transport.children import Children
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    EndpointKind,
    GraphEntity,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
)
from goalwire.transport.dds.client import DdsClient
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.endpoint_builder import EndpointBuilder
from goalwire.transport.dds.service import DdsService
from goalwire.transport.dds.topics import DdsPublisher, DdsSubscription
from goalwire.transport.endpoint_state import EndpointState

P = TypeVar('P', bound=Port)


class DdsNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(self, context: DdsContext, name: NodeName, forget: Callable[[bytes], None]) -> None:
        self.id = context.next_id()
        self.gid = context.participant.guid[:12] + self.id.to_bytes(4, 'big')
        self._context = context
        self._forget = forget
        self._entity = GraphEntity(
            EndpointKind.NODE, context.id, self.id, replace(name, enclave=context.enclave), gid=self.gid
        )
        self._state = EndpointState(f"node '{name.qualified}'", context.guard, self._leave, name.logger)
        self._ports = Children(self._state)
        context.announcement.add_node(self.id, name)
        context.announce()
        context.notifier.change([(True, self._entity)])

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._declaring(endpoint) as new:
            port = DdsPublisher(self._context, new, endpoint)
            return self._keep(port, new, endpoint, (), (port.gid,))

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._declaring(endpoint) as new:
            port = DdsSubscription(self._context, new, endpoint, deliver)
            return self._keep(port, new, endpoint, (port.gid,), ())

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._declaring(endpoint) as new:
            port = DdsService(self._context, new, endpoint, deliver)
            return self._keep(port, new, endpoint, *port.gids)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._declaring(endpoint) as new:
            port = DdsClient(self._context, new, endpoint)
            return self._keep(port, new, endpoint, *port.gids)

    @contextmanager
    def _declaring(self, endpoint: Endpoint) -> Iterator[EndpointBuilder]:
        """Prepare an endpoint; whatever was declared of it is undone where the block fails."""
        self._state.check()
        new = EndpointBuilder(self._context)
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        new.state = EndpointState(title, self._context.guard, new.undo.close, self._entity.node.logger)
        try:
            yield new
        except BaseException:
            new.state.close()
            self._state.check()  # closed by another thread in the meantime
            raise

    def _keep(
        self,
        port: P,
        new: EndpointBuilder,
        endpoint: Endpoint,
        readers: Iterable[bytes],
        writers: Iterable[bytes],
    ) -> P:
        self._ports.keep(port)
        new.undo.callback(self._ports.forget, port.gid)
        entity = replace(
            self._entity,
            kind=endpoint.kind,
            name=endpoint.name,
            type_name=endpoint.type_name,
            type_hash=_shown_hash(endpoint),
            qos=endpoint.qos.stated(),
            gid=port.gid,
        )
        self._context.notifier.change([(True, entity)])
        new.undo.callback(self._context.notifier.change, [(False, entity)])
        new.show(self.id, readers, writers)
        return port

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self._state.close()

    def _leave(self) -> None:
        self._ports.close()
        self._context.announcement.remove_node(self.id)
        self._context.announce()
        self._context.notifier.change([(False, self._entity)])
        self._forget(self.gid)


def _shown_hash(endpoint: Endpoint) -> str:
    """A service's hash is not told to others, so it is not shown here either, where it could be compared."""
    is_topic = endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
    return endpoint.type_hash if is_topic else ''
