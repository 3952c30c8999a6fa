"""Service servers: they answer each client in the form of its request."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import time_ns
from typing import NamedTuple, TypeAlias

from goalwire.errors import RemoteError
from goalwire.fault_reports import report_failure
from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.qos import RELIABLE
from goalwire.rtps.protocol.reader import ReaderListener
from goalwire.rtps.protocol.reader import Sample as RtpsSample
from goalwire.rtps.protocol.writer import WriterListener
from goalwire.transport.contract import Endpoint, Request, new_sample
from goalwire.transport.dds.description import EndpointData, Role, decode_endpoint
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.dialects import (
    CYCLONE_VENDOR,
    ReturnAddress,
    read_request,
    write_refusal,
    write_reply,
)
from goalwire.transport.dds.native.service_ends import WaitingSamples, make_reader, make_writer, side_of
from goalwire.transport.dds.service_server import DdsRequest, DdsServer
from goalwire.transport.endpoint import EndpointState

MATCHING_S = 0.1
"""How long a reply waits for its client's reader, as in rmw_cyclonedds and rmw_fastrtps."""


class Client(NamedTuple):
    """A client, as its request writer describes it."""

    side: tuple[bytes, str]
    """The client's participant, and the id that its reader and writer share."""
    has_id: bool
    """True if the client announces an id. Otherwise any reader of its participant may be the client's."""
    has_header: bool
    takes_refusals: bool


NativeRequest: TypeAlias = DdsRequest[Client, ReturnAddress, tuple[bytes, bytes]]


class _Outgoing:
    """One reply whose reader is not known yet."""

    __slots__ = ('is_over', 'payload', 'qos', 'request')

    def __init__(self, request: NativeRequest, payload: bytes, qos: bytes) -> None:
        self.request = request
        self.payload = payload
        self.qos = qos
        self.is_over = False
        """True once the reply has waited for MATCHING_S."""


class NativeService(DdsServer[Client, ReturnAddress, tuple[bytes, bytes]]):
    """A declared service server."""

    write_reply = staticmethod(write_reply)
    write_refusal = staticmethod(write_refusal)

    def __init__(
        self,
        context: NativeContext,
        state: EndpointState,
        endpoint: Endpoint,
        deliver: Callable[[Request], None],
    ) -> None:
        self._context = context
        self._deliver = deliver
        self._clients: dict[bytes, Client] = {}
        """The clients by the GUIDs of their request writers."""
        self._unsent = WaitingSamples()
        self._unmatched: list[_Outgoing] = []
        """Replies to clients whose readers are not known yet."""
        self._early: list[RtpsSample] | None = []
        """Requests that have come before `begin`; None after `begin`."""
        self._readers: dict[tuple[bytes, str], bytes] = {}
        """The GUID of the reader that takes replies, by the `Client.side` of its clients."""
        data = EndpointData(endpoint.type_hash, service_id=context.next_service_id())
        self._writer = make_writer(context, state, endpoint, data, Role.REPLY, _WriterEvents(self))
        self._reader = make_reader(context, state, endpoint, data, Role.REQUEST, _ReaderEvents(self))
        super().__init__(state, self._reader.data.guid)

    def begin(self) -> None:
        """Take the requests that have come already, and all later ones."""
        participant = self._context.participant
        participant.run(partial(participant.tell, self._begin), None)

    def _begin(self) -> None:
        early, self._early = self._early, None
        for sample in early or ():
            self.take_request(sample)

    # ---- requests

    def take_request(self, sample: RtpsSample) -> None:
        """Deliver a request to the server's function; one that breaks the rules is counted and ignored."""
        if self._early is not None:
            self._early.append(sample)
            return
        payload, writer = sample.payload, sample.writer
        client = self._clients.get(writer)
        if client is None:
            client = self._describe(writer)
        if payload is None or client is None or self.state.closed:
            return  # the client has gone, or this server is closed
        try:
            address, sequence, message = read_request(
                sample.qos, payload, writer, sample.number, has_header=client.has_header
            )
        except RemoteError as error:
            self._context.rejects.add('request', error, self.state)
            return
        now = time_ns()
        request = DdsRequest(
            self, client, address, new_sample((message, sequence, sample.time or now, now, writer))
        )
        self.waiting[request] = True
        try:
            self._deliver(request)
        except Exception as error:
            report_failure(self.state.title, error)
            request.cancel()

    def _describe(self, writer: bytes) -> Client | None:
        """Return a description of the client that has this request writer; None if the client has gone."""
        proxy = self._reader.writers.get(writer)
        if proxy is None:
            return None
        told = decode_endpoint(proxy.data.user_data)
        vendor = self._context.participant.vendor_of(proxy.data.prefix)
        side = proxy.data.prefix, side_of(proxy.data)
        client = Client(side, bool(told.client_id), vendor == CYCLONE_VENDOR, told.takes_refusals)
        self._clients[writer] = client
        return client

    def forget_client(self, writer: bytes) -> None:
        """Forget a client that has gone."""
        self._clients.pop(writer, None)

    # ---- replies

    def send(self, request: NativeRequest, reply: tuple[bytes, bytes]) -> None:
        """Send one reply once its client can receive it."""
        self._context.participant.run(partial(self._send_now, request, *reply), None)

    def _send_now(self, request: NativeRequest, payload: bytes, qos: bytes) -> None:
        """Send a reply, or let it wait. Runs inside `Wire.run`."""
        reader, writer = self._find_reader(request), self._writer
        is_due = reader in writer.readers and not self._unsent.queues
        if not is_due or writer.add(payload, qos, reader) is None:
            self._send(_Outgoing(request, payload, qos))

    def _send(self, reply: _Outgoing) -> None:
        """Send a reply, or let it wait for its reader or for room. Runs inside `Wire.run`."""
        reader = self._find_reader(reply.request)
        if reader is not None:
            self._unsent.send(reader, partial(self._send_to, reader, reply))
        elif reply.is_over:
            self._context.participant.tell(self._note_deaf)
        else:
            participant = self._context.participant
            self._unmatched.append(reply)
            participant.timers.at(participant.clock() + MATCHING_S, partial(self._give_up, reply))

    def _find_reader(self, request: NativeRequest) -> bytes | None:
        """Return the matched reader that a reply is for; None if it is not matched."""
        client, named = request.client, request.address.reader
        if client.has_id or not named:
            # Clients of one session share a reader. The reader that a request names may be one that is
            # announced but receives nothing (replies.py).
            return self._readers.get(client.side)
        return named if named in self._writer.readers else None

    def _send_to(self, reader: bytes, reply: _Outgoing) -> bool:
        writer = self._writer
        if reader not in writer.readers:
            return True
        return writer.add(reply.payload, reply.qos, reader) is not None

    def _give_up(self, reply: _Outgoing) -> None:
        if reply in self._unmatched:
            self._unmatched.remove(reply)
            reply.is_over = True
            self._send(reply)

    def _note_deaf(self) -> None:
        self._context.rejects.add('reply', 'its client does not listen to replies', self.state)

    def send_waiting(self) -> None:
        """Send the replies that waited for room or for their readers, as far as possible now."""
        if self._early is None:  # before `begin` no request was answered
            self._context.participant.run(self._send_waiting, None)

    def _send_waiting(self) -> None:
        unmatched, self._unmatched = self._unmatched, []
        for reply in unmatched:
            if self._find_reader(reply.request) is None:
                self._unmatched.append(reply)  # its timer of MATCHING_S is already running
            else:
                self._send(reply)
        self._unsent.send_all()

    def meet_reader(self, reader: RtpsEndpoint) -> None:
        """Note a client's reader. Of several readers of a side, the first or a reliable one takes replies."""
        side = reader.prefix, side_of(reader)
        if reader.qos.reliability == RELIABLE or side not in self._readers:
            self._readers[side] = reader.guid
        self.send_waiting()

    def lose_reader(self, reader: RtpsEndpoint) -> None:
        """Forget a client's reader, and choose another one of the same side, if there is one."""
        side = reader.prefix, side_of(reader)
        if self._readers.get(side) == reader.guid:
            del self._readers[side]
            for proxy in list(self._writer.readers.values()):
                if (proxy.data.prefix, side_of(proxy.data)) == side:
                    self.meet_reader(proxy.data)
        self._context.participant.run(partial(self._unsent.discard, reader.guid), None)

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """The gids of the server's readers and writers."""
        return (self.gid,), (self._writer.data.guid,)


class _WriterEvents(WriterListener):
    """Reports the clients' readers that a server's writer is matched with."""

    def __init__(self, service: NativeService) -> None:
        self._service = service
        self.on_room = service.send_waiting  # type: ignore[method-assign]

    def on_matched(self, reader: RtpsEndpoint) -> None:
        self._service.meet_reader(reader)

    def on_unmatched(self, reader: RtpsEndpoint) -> None:
        self._service.lose_reader(reader)


class _ReaderEvents(ReaderListener):
    """Reports the clients' writers that a server's reader is matched with, and their requests."""

    def __init__(self, service: NativeService) -> None:
        self._service = service
        self.on_sample = service.take_request  # type: ignore[method-assign]

    def on_unmatched(self, writer: RtpsEndpoint) -> None:
        self._service.forget_client(writer.guid)
