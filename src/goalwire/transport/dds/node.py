"""Nodes: part of ros_discovery_info, and the endpoints declared through them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from goalwire.records import replace
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
from goalwire.transport.dds.core import Core
from goalwire.transport.dds.declaring import Declaration
from goalwire.transport.dds.service import DdsService
from goalwire.transport.dds.topics import DdsPublisher, DdsSubscription
from goalwire.transport.members import Members
from goalwire.transport.place import Place

P = TypeVar('P', bound=Port)


class DdsNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(self, core: Core, name: NodeName, forget: Callable[[bytes], None]) -> None:
        self.id = core.next_id()
        self.gid = core.participant.guid[:12] + self.id.to_bytes(4, 'big')
        self._core = core
        self._forget = forget
        self._entity = GraphEntity(
            EndpointKind.NODE, core.id, self.id, replace(name, enclave=core.enclave), gid=self.gid
        )
        self._place = Place(f"node '{name.qualified}'", core.guard, self._leave, name.logger)
        self._ports = Members(self._place)
        core.announcement.add_node(self.id, name)
        core.announce()
        core.feed.change([(True, self._entity)])

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._declaring(endpoint) as new:
            port = DdsPublisher(self._core, new, endpoint)
            return self._keep(port, new, endpoint, (), (port.gid,))

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._declaring(endpoint) as new:
            port = DdsSubscription(self._core, new, endpoint, deliver)
            return self._keep(port, new, endpoint, (port.gid,), ())

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._declaring(endpoint) as new:
            port = DdsService(self._core, new, endpoint, deliver)
            return self._keep(port, new, endpoint, *port.gids)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._declaring(endpoint) as new:
            port = DdsClient(self._core, new, endpoint)
            return self._keep(port, new, endpoint, *port.gids)

    @contextmanager
    def _declaring(self, endpoint: Endpoint) -> Iterator[Declaration]:
        """Prepare an endpoint; whatever was declared of it is undone where the block fails."""
        self._place.check()
        new = Declaration(self._core)
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        new.place = Place(title, self._core.guard, new.undo.close, self._entity.node.logger)
        try:
            yield new
        except BaseException:
            new.place.give_up()
            self._place.check()  # closed by another thread in the meantime
            raise

    def _keep(
        self,
        port: P,
        new: Declaration,
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
        self._core.feed.change([(True, entity)])
        new.undo.callback(self._core.feed.change, [(False, entity)])
        new.show(self.id, readers, writers)
        return port

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self._place.give_up()

    def _leave(self) -> None:
        self._ports.close()
        self._core.announcement.remove_node(self.id)
        self._core.announce()
        self._core.feed.change([(False, self._entity)])
        self._forget(self.gid)


def _shown_hash(endpoint: Endpoint) -> str:
    """A service's hash is not told to others, so it is not shown here either, where it could be compared."""
    is_topic = endpoint.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
    return endpoint.type_hash if is_topic else ''
