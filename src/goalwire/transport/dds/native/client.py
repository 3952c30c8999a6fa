"""Service clients. Each server gets requests in its vendor's form; a reply names its request by number."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from time import time_ns

from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.lingering import LINGER_S
from goalwire.rtps.protocol.writer import WriterListener
from goalwire.transport.contract import Endpoint, Sample, new_sample
from goalwire.transport.dds.description import GUID_PREFIX_SIZE, EndpointData, Role
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.dialects import Dialect, Reply, dialect_of, request_qos
from goalwire.transport.dds.native.replies import ReplyReaders
from goalwire.transport.dds.native.service_ends import WaitingSamples, make_writer, side_of
from goalwire.transport.dds.service_header import wrap
from goalwire.transport.dds.session import ClientEnd
from goalwire.transport.endpoint import EndpointState


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
        """The servers that may still answer, by the GUIDs of their readers, with the number under which the
        request was sent to each; 0 before that."""
        self.reason = ''
        """The reason of the first server that has refused the request; others may still answer it."""


class NativeClient(ClientEnd):
    """A declared service client."""

    def __init__(
        self, context: NativeContext, readers: ReplyReaders, state: EndpointState, endpoint: Endpoint
    ) -> None:
        self._context = context
        self._next_sequence = count(1).__next__
        self._calls: dict[int, Call] = {}
        """The calls by the numbers that `request` has returned."""
        self._asked: dict[int, tuple[Call, bytes]] = {}
        """The calls by the numbers on the wire, each with the server that got this number."""
        self._waiting = WaitingSamples()
        self._dialects: dict[bytes, Dialect] = {}
        """The forms of requests that the servers expect, by the GUIDs of their readers."""
        self._leaving: dict[bytes, str] = {}
        """The servers whose readers have gone and whose writers have not, by the GUIDs of their readers, each
        with its `side_of`."""
        self._awaited = context.awaited
        self._reaches = False
        self._has_begun = False
        """False until `begin`. The writer's events may come earlier, while the client is still being made."""
        self._replies = replies = readers.take(endpoint)
        state.undo.append(partial(readers.give_back, replies))
        self._name = replies.make_name()
        """The GUID that this client's requests name in the dialect INLINE, so that replies find it."""
        state.undo.append(partial(replies.drop_name, self._name))
        data = EndpointData(endpoint.type_hash, client_id=replies.client_id, takes_refusals=True)
        self._writer = make_writer(context, state, endpoint, data, Role.REQUEST, _WriterEvents(self))
        super().__init__(state, self._writer.data.guid)
        self._handle = int.from_bytes(self.gid[8:], 'little')
        """The client's number in headers, in which Cyclone DDS puts the writer's instance handle."""
        self._request_qos = request_qos(self._name)
        names = self._name, self.gid, self._handle
        self._listen = partial(replies.add, self, names)
        state.undo += [partial(replies.remove, self, names), self.close_calls]

    def begin(self) -> None:
        """Begin to follow the servers: those that are there already, and those that come later."""
        participant = self._context.participant
        participant.run(partial(participant.tell, self._begin), None)

    def _begin(self) -> None:
        self._has_begun = True
        self._listen()
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
        """Send a request to all servers that there are. Runs inside `Wire.run`."""
        readers = self._writer.readers
        is_alone = len(readers) == 1
        for guid in readers:
            call.servers[guid] = 0
            to = None if is_alone else guid
            if self._waiting.queues or not self._send_to(call, payload, guid, to):
                self._waiting.send(guid, partial(self._send_to, call, payload, guid, to))
        if not call.servers:
            self._context.participant.tell(self._end, call)

    def _send_to(self, call: Call, payload: bytes, server: bytes, to: bytes | None) -> bool:
        """Send a request to one server, given by its reader; False if there is no room."""
        if server not in call.servers or call.sequence not in self._calls:
            return True  # the call has ended meanwhile
        writer, qos = self._writer, b''
        dialect = self._dialects.get(server) or self._find_dialect(server)
        if dialect is Dialect.INLINE:
            qos = self._request_qos
        elif dialect is Dialect.HEADER:
            payload = wrap((self._handle, writer.last + 1), payload)
        number = writer.add(payload, qos, to)
        if number is None:
            return False
        # The reply cannot be read before this line: `Wire.run` lets only one thread in.
        self._asked[number] = call, server
        call.servers[server] = number
        return True

    def _find_dialect(self, server: bytes) -> Dialect:
        """Return the form of requests that a server expects, and remember it."""
        vendor = self._context.participant.vendor_of(server[:GUID_PREFIX_SIZE])
        self._dialects[server] = dialect = dialect_of(vendor)
        return dialect

    def send_waiting(self) -> None:
        """Send the requests that waited for room, as far as there is room now."""
        self._context.participant.run(self._waiting.send_all, None)

    def cancel(self, sequence: int) -> None:
        """Forget a request. One that has ended is ignored."""
        call = self._calls.pop(sequence, None)
        if call is not None:
            self._forget(call)

    def _forget(self, call: Call) -> None:
        self._awaited.pop(call, None)
        for number in list(call.servers.values()):
            self._asked.pop(number, None)

    def _end(self, call: Call) -> None:
        """End a call: no server will answer it any more."""
        if self._calls.pop(call.sequence, None) is not None:
            self._forget(call)
            call.on_end(call.reason)

    # ---- what comes

    def take_reply(self, reply: Reply, time: int | None) -> None:
        """Give a reply to its call; `time` is when the reply was written."""
        found = self._asked.pop(reply.number, None)
        if found is None:
            return
        call, server = found
        # The reply acknowledges the request, so no HEARTBEAT has to ask for an ACKNACK. That saves two of six
        # packets a call, for clients with fewer than a hundred calls a second.
        self._writer.note_received(server, reply.number)
        if reply.refusal is not None:
            call.reason = call.reason or reply.refusal
        else:
            now = time_ns()
            call.on_reply(new_sample((reply.message, call.sequence, time or now, now, self.gid)))
        call.servers.pop(server, None)
        # hot path: `_end` is written out for a call that waits for no server, which saves two function calls.
        if not call.servers and self._calls.pop(call.sequence, None) is not None:
            self._awaited.pop(call, None)
            call.on_end(call.reason)

    # ---- servers that come and go

    def look(self) -> None:
        """Find out again whether a server can be called, and its reply can arrive."""
        asked = {
            side_of(proxy.data)
            for proxy in list(self._writer.readers.values())
            if proxy.has_answered or not proxy.is_reliable
        }
        self._reaches = not asked.isdisjoint(self._replies.answering())

    def on_change(self) -> None:
        """Note that a server's reader or writer has come, has answered, or has gone."""
        if self._has_begun:
            self.look()
            self._context.notifier.connected()

    def lose_reader(self, reader: RtpsEndpoint) -> None:
        """Note that a server's reader has gone. Its replies to earlier requests may still come.

        A server that ends after its reply deletes its reader at once. Its writer stays until the reply is
        acknowledged, at most `LINGER_S`, so the calls wait for the end of the writer.
        """
        guid, side = reader.guid, side_of(reader)
        self._context.participant.run(partial(self._waiting.discard, guid), None)
        if side in self._replies.writing():
            self._leaving[guid] = side
            self._context.call_later(2 * LINGER_S, partial(self._lose_server, guid))
        else:
            self._lose_server(guid)

    def lose_writer(self, side: str) -> None:
        """Note that a server's writer has gone, given by its `side_of`."""
        for reader in [reader for reader, its_side in self._leaving.copy().items() if its_side == side]:
            self._lose_server(reader)

    def _lose_server(self, reader: bytes) -> None:
        """Remove a server that has gone from all calls; end calls that wait for no other server."""
        self._leaving.pop(reader, None)
        self._dialects.pop(reader, None)
        for call in list(self._calls.values()):
            number = call.servers.pop(reader, None)
            if number is not None:
                self._asked.pop(number, None)
                if not call.servers:
                    self._end(call)

    def reaches_server(self) -> bool:
        """Return whether a server's reader and writer both know this client's writer and reader."""
        return self._reaches

    def close_calls(self) -> None:
        """End every call: the client is closing."""
        for call in list(self._calls.values()):
            self._end(call)

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """The gids of the client's readers and writers."""
        return (self._name,), (self.gid,)


class _WriterEvents(WriterListener):
    """Reports the servers' readers that a client's writer is matched with."""

    def __init__(self, client: NativeClient) -> None:
        self._client = client
        self.on_room = client.send_waiting  # type: ignore[method-assign]

    def on_answered(self, reader: RtpsEndpoint) -> None:  # noqa: ARG002
        self._client.on_change()

    def on_unmatched(self, reader: RtpsEndpoint) -> None:
        self._client.lose_reader(reader)
        self._client.on_change()
