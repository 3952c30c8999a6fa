"""A session on goalwire's own RTPS."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.concurrency.descriptors import require_free
from goalwire.errors import TransportError
from goalwire.transport.contract import Endpoint, Request, Sample, SessionOptions
from goalwire.transport.dds.native.client import NativeClient
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.replies import ReplyReaders
from goalwire.transport.dds.native.rmw import RmwDefaults
from goalwire.transport.dds.native.service import NativeService
from goalwire.transport.dds.native.topics import NativePublisher, NativeSubscription
from goalwire.transport.dds.session import ClientEnd, DdsSession, EndpointFactory, Made, PublisherEnd
from goalwire.transport.endpoint import EndpointState, OpenPort
from goalwire.transport.loopback import ADVICE, is_loopback_down


class _Endpoints(EndpointFactory):
    def __init__(self, context: NativeContext) -> None:
        self._context = context
        self._reply_readers = ReplyReaders(context)

    def publisher(self, state: EndpointState, endpoint: Endpoint) -> Made[PublisherEnd]:
        port = NativePublisher(self._context, state, endpoint)
        return Made(port, (), (port.gid,))

    def subscription(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Sample], None]
    ) -> Made[OpenPort]:
        port = NativeSubscription(self._context, state, endpoint, deliver)
        return Made(port, (port.gid,), ())

    def service(
        self, state: EndpointState, endpoint: Endpoint, deliver: Callable[[Request], None]
    ) -> Made[OpenPort]:
        port = NativeService(self._context, state, endpoint, deliver)
        return Made(port, *port.gids, port.begin)

    def client(self, state: EndpointState, endpoint: Endpoint) -> Made[ClientEnd]:
        port = NativeClient(self._context, self._reply_readers, state, endpoint)
        return Made(port, *port.gids, port.begin)


def open_session(options: SessionOptions, defaults: RmwDefaults) -> NativeSession:
    """Join a domain. Raises TransportError or ForkedError."""
    require_free('a session on DDS')
    if is_loopback_down():
        raise TransportError(f'cannot open a session on DDS: {ADVICE}')
    return NativeSession(NativeContext(options.domain_id, options.enclave, defaults))


class NativeSession(DdsSession):
    """An open session and its nodes."""

    def __init__(self, context: NativeContext) -> None:
        super().__init__(context, _Endpoints(context))
        self.wire_poller = context.wire_poller
