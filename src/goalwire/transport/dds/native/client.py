"""Service clients: each server gets a request in its vendor's form, and is found again by its number."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from time import time_ns

from goalwire.errors import RemoteError
from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.reader import ReaderListener
from goalwire.rtps.protocol.reader import Sample as RtpsSample
from goalwire.rtps.protocol.reader_proxy import ReaderProxy
from goalwire.rtps.protocol.writer import WriterListener
from goalwire.transport.contract import Endpoint, Sample, new_sample
from goalwire.transport.dds.description import EndpointData, Role
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.dialects import Dialect, dialect_of, read_reply, request_qos
from goalwire.transport.dds.native.ends import WaitingSamples, make_ends, side_of
from goalwire.transport.dds.service_header import wrap
from goalwire.transport.dds.session import ClientEnd
from goalwire.transport.endpoint import EndpointState

SILENCE_S = 0.25
"""A server's writer that has told nothing for so long is taken to know the client. RustDDS is silent until it
writes; Fast DDS and Cyclone DDS tell within 0.1 s that they have nothing."""


class Call:
    """One request on its way."""

    __slots__ = ('on_end', 'on_reply', 'reason', 'sequence', 'servers')

    def __init__(
        self, sequence: int, on_reply: Callable[[Sample], None], on_end: Callable[[str], None]
    ) -> None:
        self.sequence = sequence
        self.on_reply = on_reply
        self.on_end = on_end
        self.servers: dict[bytes, int] = {}
        """The servers that may still answer, by the GUIDs of their readers; and how each counts the request:
        0 as long as it is not sent."""
        self.reason = ''
        """Why a server has refused it, that others may still answer."""


class NativeClient(ClientEnd):
    """A declared service client."""

    def __init__(self, context: NativeContext, state: EndpointState, endpoint: Endpoint) -> None:
        self._context = context
        self._next_sequence = count(1).__next__
        self._calls: dict[int, Call] = {}
        """By the number that the caller knows."""
        self._asked: dict[int, tuple[Call, bytes]] = {}
        """By the number that a server knows, with that server."""
        self._waiting = WaitingSamples()
        self._awaited = context.awaited
        self._reaches = False
        self._has_begun = False
        """Events come as soon as there is one end."""
        data = EndpointData(endpoint.type_hash, client_id=context.next_service_id(), takes_refusals=True)
        listeners = _WriterEvents(self), _ReaderEvents(self)
        self._ends = ends = make_ends(context, state, endpoint, data, Role.REQUEST, listeners)
        super().__init__(state, ends.writer.data.guid)
        self._own = ends.reader.data.guid, self.gid
        self._handle = int.from_bytes(self.gid[8:], 'little')
        """As the instance handle of its writer in Cyclone DDS: it tells clients apart."""
        self._request_qos = request_qos(ends.reader.data.guid)
        state.undo.append(self.close_calls)

    def begin(self) -> None:
        """Take note of servers from now on, and of those that are there."""
        participant = self._context.participant
        participant.run(partial(participant.tell, self._begin), None)

    def _begin(self) -> None:
        self._has_begun = True
        self.on_change()

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,  # noqa: ARG002 - it is cancelled in time
    ) -> int:
        """Send one request to every server."""
        state = self.state
        if state.closed or state.guard.is_silent:
            state.check_sending()
        sequence = self._next_sequence()
        call = Call(sequence, on_reply, on_end)
        self._calls[sequence] = call
        self._awaited[call] = None
        self._context.participant.run(partial(self._send, call, payload), None)
        if state.closed:
            self._end(call)
        return sequence

    def _send(self, call: Call, payload: bytes) -> None:
        """Send a request to all servers that there are. Inside `Wire.run`."""
        readers = self._ends.writer.readers
        is_alone = len(readers) == 1
        for guid, proxy in readers.items():
            call.servers[guid] = 0
            to = None if is_alone else guid
            self._waiting.send(guid, partial(self._send_to, call, payload, proxy, to))
        if not call.servers:
            self._context.participant.tell(self._end, call)

    def _send_to(self, call: Call, payload: bytes, proxy: ReaderProxy, to: bytes | None) -> bool:
        """Send a request to one server; False if there is no room."""
        server = proxy.data.guid
        if server not in call.servers or call.sequence not in self._calls:
            return True  # it has ended meanwhile
        writer = self._ends.writer
        number, qos = writer.last + 1, b''
        dialect = dialect_of(self._context.participant.vendor_of(proxy.data.prefix))
        if dialect is Dialect.INLINE:
            qos = self._request_qos
        elif dialect is Dialect.HEADER:
            payload = wrap((self._handle, number), payload)
        self._asked[number] = call, server
        if writer.add(payload, qos, to) is None:
            del self._asked[number]
            return False
        call.servers[server] = number
        return True

    def send_waiting(self) -> None:
        """Send what has waited for room."""
        self._context.participant.run(self._waiting.send_all, None)

    def cancel(self, sequence: int) -> None:
        """Hold nothing for this request any more."""
        call = self._calls.pop(sequence, None)
        if call is not None:
            self._forget(call)

    def _forget(self, call: Call) -> None:
        self._awaited.pop(call, None)
        for number in list(call.servers.values()):
            self._asked.pop(number, None)

    def _end(self, call: Call) -> None:
        """Nobody will answer any more."""
        if self._calls.pop(call.sequence, None) is not None:
            self._forget(call)
            call.on_end(call.reason)

    # ---- what comes

    def take_reply(self, sample: RtpsSample) -> None:
        """Take a reply, this client's or another's."""
        if sample.payload is None or not self._has_begun:
            return
        try:
            reply = read_reply(sample.qos, sample.payload, self._own, self._handle)
        except RemoteError as error:
            self._context.rejects.add('reply', error, self.state)
            return
        found = None if reply is None else self._asked.pop(reply.number, None)
        if reply is None or found is None:
            return
        call, server = found
        # The reply shows that the request has come. So no HEARTBEAT asks for that: two packets of six less
        # for a call of a client that calls less than a hundred times a second.
        self._context.participant.run(partial(self._ends.writer.note_received, server, reply.number), None)
        if reply.refusal is not None:
            call.reason = call.reason or reply.refusal
        else:
            now = time_ns()
            call.on_reply(new_sample((reply.message, call.sequence, sample.time or now, now, self.gid)))
        call.servers.pop(server, None)
        if not call.servers:
            self._end(call)

    # ---- servers that come and go

    def _look(self) -> None:
        """See whether a server can be called, and its reply be heard."""
        ends = self._ends
        asked = {
            side_of(proxy.data)
            for proxy in list(ends.writer.readers.values())
            if proxy.has_answered or not proxy.is_reliable
        }
        long_ago = self._context.participant.clock() - SILENCE_S
        answering = {
            side_of(proxy.data)
            for proxy in list(ends.reader.writers.values())
            if proxy.next or not proxy.is_reliable or proxy.matched_at <= long_ago
        }
        self._reaches = not asked.isdisjoint(answering)

    def on_change(self) -> None:
        """An end of a server has come, has answered, or has gone."""
        if self._has_begun:
            self._look()
            self._context.notifier.connected()

    def expect_server(self) -> None:
        """A server's writer has come; some tell nothing of themselves before they have written."""
        self._context.call_later(2 * SILENCE_S, self.on_change)

    def lose_server(self, reader: bytes) -> None:
        """A server has gone: it answers nothing more."""
        self._context.participant.run(partial(self._waiting.discard, reader), None)
        for call in list(self._calls.values()):
            number = call.servers.pop(reader, None)
            if number is not None:
                self._asked.pop(number, None)
                if not call.servers:
                    self._end(call)

    def reaches_server(self) -> bool:
        """Whether both ends of a server know ours."""
        return self._reaches

    def close_calls(self) -> None:
        """End every call: the client is closing."""
        for call in list(self._calls.values()):
            self._end(call)

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """The gids of its readers and writers."""
        return self._own[:1], self._own[1:]


class _WriterEvents(WriterListener):
    """Tells a client of its servers' readers."""

    def __init__(self, client: NativeClient) -> None:
        self._client = client
        self.on_room = client.send_waiting  # type: ignore[method-assign]

    def on_answered(self, reader: RtpsEndpoint) -> None:  # noqa: ARG002
        self._client.on_change()

    def on_unmatched(self, reader: RtpsEndpoint) -> None:
        self._client.lose_server(reader.guid)
        self._client.on_change()


class _ReaderEvents(ReaderListener):
    """Tells a client of its servers' writers, and of their replies."""

    def __init__(self, client: NativeClient) -> None:
        self._client = client
        self.on_sample = client.take_reply  # type: ignore[method-assign]

    def on_matched(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._client.expect_server()

    def on_answered(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._client.on_change()

    def on_unmatched(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._client.on_change()
