"""A session on libddsc."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.concurrency.descriptors import require_free
from goalwire.transport.contract import Endpoint, Request, Sample, SessionOptions
from goalwire.transport.dds.cyclone.context import CycloneContext, EndpointBuilder
from goalwire.transport.dds.cyclone.library import load
from goalwire.transport.dds.cyclone.services import CycloneClient, CycloneService
from goalwire.transport.dds.cyclone.topics import DdsPublisher, DdsSubscription
from goalwire.transport.dds.session import ClientEnd, DdsSession, EndpointFactory, Made, PublisherEnd
from goalwire.transport.endpoint import EndpointState, OpenPort


class _Endpoints(EndpointFactory):
    def __init__(self, context: CycloneContext) -> None:
        self._context = context

    def publisher(self, state: EndpointState, endpoint: Endpoint) -> Made[PublisherEnd]:
        new = EndpointBuilder(self._context, state)
        port = DdsPublisher(self._context, new, endpoint)
        return Made(port, (), (port.gid,), new.begin)

    def subscription(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Sample], None]
    ) -> Made[OpenPort]:
        new = EndpointBuilder(self._context, state)
        port = DdsSubscription(self._context, new, endpoint, deliver)
        return Made(port, (port.gid,), (), new.begin)

    def service(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Request], None]
    ) -> Made[OpenPort]:
        new = EndpointBuilder(self._context, state)
        port = CycloneService(self._context, new, endpoint, deliver)
        return Made(port, *port.gids, new.begin)

    def client(self, state: EndpointState, endpoint: Endpoint) -> Made[ClientEnd]:
        new = EndpointBuilder(self._context, state)
        port = CycloneClient(self._context, new, endpoint)
        return Made(port, *port.gids, new.begin)


def open_session(options: SessionOptions) -> CycloneSession:
    """Join a domain. Raises TransportError or ForkedError."""
    require_free('a session on DDS')
    return CycloneSession(CycloneContext(load(), options.domain_id, options.enclave))


class CycloneSession(DdsSession):
    """An open session and its nodes."""

    def __init__(self, context: CycloneContext) -> None:
        super().__init__(context, _Endpoints(context))
        self.wire_poller = context.wire_poller
        self.state.undo.append(context.participant.leave_at_once)
