"""Service clients and servers. Each has two ends, a writer and a reader, with one id for both.

A client writes requests and reads replies, also those for other clients. A server reads requests and writes
replies, which go to all clients. The header (service_header.py) says which client a reply is for.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_ssize_t
from functools import partial
from itertools import count
from threading import Lock
from time import monotonic_ns, time_ns
from typing import NamedTuple, NoReturn, TypeAlias

from goalwire.errors import RemoteError, TransportError
from goalwire.fault_reports import log_rejected, report_failure
from goalwire.records import replace
from goalwire.rules.qos import HistoryPolicy
from goalwire.transport.contract import Endpoint, NodeName, Request, Sample, new_sample
from goalwire.transport.dds.cyclone.context import CycloneContext, EndpointBuilder
from goalwire.transport.dds.cyclone.delivery import QueueingWriter, ReaderDispatcher
from goalwire.transport.dds.cyclone.qos import endpoint_qos
from goalwire.transport.dds.cyclone.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED, Peer
from goalwire.transport.dds.cyclone.wire import RawSample, Reader, Writer
from goalwire.transport.dds.description import EndpointData, Role, dds_topic, dds_type, encode_endpoint
from goalwire.transport.dds.environment import CHOICE
from goalwire.transport.dds.service_header import (
    Header,
    refusal,
    refusal_reason,
    unwrap,
    wrap,
)
from goalwire.transport.dds.service_server import DdsRequest, DdsServer
from goalwire.transport.dds.session import ClientEnd

_FOREIGN = (
    'its server runs on Fast DDS, whose services take requests of another form than libddsc sends: '
    f'unset {CHOICE} here'
)


_FALLBACK_DEPTH = 100
"""How many replies the fallback writer keeps. With more, a client that does not acknowledge would block this
writer, too: the library may have no room once 30 KB are not acknowledged."""


def _user_data(role: Role, endpoint: Endpoint, data: EndpointData) -> bytes:
    """Return the user data of a reader or writer. Its hash is that of the request or of the response."""
    if endpoint.part_hashes is not None:
        of_request, of_response = endpoint.part_hashes()
        data = data._replace(type_hash=of_request if role is Role.REQUEST else of_response)
    return encode_endpoint(data)


def make_writer(
    context: CycloneContext,
    role: Role,
    endpoint: Endpoint,
    data: EndpointData,
    undo: list[Callable[[], object]],
) -> QueueingWriter:
    """Declare the writer. It keeps all samples: with ROS 2's depth of ten, a burst would lose some.

    Only servers have a fallback writer. A client's requests must all come from one writer, which identifies
    it.
    """
    topic = dds_topic(role, endpoint.name, verbatim=endpoint.qos.avoid_ros_namespace_conventions)
    where = context.participant, topic, dds_type(role, endpoint.type_name)
    said = _user_data(role, endpoint, data)

    def make_fallback() -> Writer:
        short = replace(endpoint.qos, history=HistoryPolicy.KEEP_LAST, depth=_FALLBACK_DEPTH)
        with endpoint_qos(context.library, short, said, blocking_ns=0) as qos:
            return Writer(*where, qos)

    kept = replace(endpoint.qos, history=HistoryPolicy.KEEP_ALL)
    with endpoint_qos(context.library, kept, said, blocking_ns=0) as qos:
        if role is Role.REPLY:
            writer = QueueingWriter(*where, qos, make_fallback)
        else:
            writer = QueueingWriter(*where, qos, guard=context.guard)
    undo.append(writer.delete)
    undo.append(partial(context.statuses.discard, writer.handle))
    return writer


def make_reader(
    context: CycloneContext,
    role: Role,
    endpoint: Endpoint,
    data: EndpointData,
    undo: list[Callable[[], object]],
) -> Reader:
    """Declare the reader. It keeps all samples: a lost one would leave a call without an answer."""
    verbatim = endpoint.qos.avoid_ros_namespace_conventions
    topic = dds_topic(role, endpoint.name, verbatim=verbatim)
    kept = replace(endpoint.qos, history=HistoryPolicy.KEEP_ALL)
    with endpoint_qos(context.library, kept, _user_data(role, endpoint, data)) as qos:
        reader = Reader(context.participant, topic, dds_type(role, endpoint.type_name), qos)
    undo.append(reader.delete)
    undo.append(partial(context.statuses.discard, reader.handle))
    return reader


class Call(NamedTuple):
    """One request on its way, and the servers that may still answer."""

    servers: set[str]
    on_reply: Callable[[Sample], None]
    on_end: Callable[[str], None]


_new_call: Callable[[tuple[set[str], Callable[[Sample], None], Callable[[str], None]]], Call] = partial(
    tuple.__new__, Call
)
"""Makes a Call by tuple.__new__, which runs no Python code."""


class CycloneClient(ClientEnd):
    """A declared service client."""

    def __init__(self, context: CycloneContext, new: EndpointBuilder, endpoint: Endpoint) -> None:
        data = EndpointData(endpoint.type_hash, client_id=context.next_service_id(), takes_refusals=True)
        self._context = context
        self._writer = make_writer(context, Role.REQUEST, endpoint, data, new.undo)
        self.reader = make_reader(context, Role.REPLY, endpoint, data, new.undo)
        super().__init__(new.state, self._writer.guid)
        self._next_sequence = count(1).__next__
        self._lock = Lock()
        self._calls: dict[int, Call] = {}
        self._refusals: dict[int, str] = {}
        """By sequence number: why the first server refused a call that other servers may still answer."""
        self._local = context.local_readers.by_topic
        self._known = context.peers.known
        self._requested: list[Peer] = []
        self._answering: list[Peer] = []
        self._targets: tuple[frozenset[str], str] = frozenset(), ''
        """The servers that get a request now, and the reason if there are none."""
        new.undo.append(self.close_calls)
        self._dispatcher = ReaderDispatcher(self.reader, new.state.title, self._on_message)
        new.take_in(self.reader.topic, self._dispatcher)
        context.statuses.watch(self._writer.handle, PUBLICATION_MATCHED, self._look)
        context.statuses.watch(self.reader.handle, SUBSCRIPTION_MATCHED, self._look)

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
        if not self._targets[0]:
            self._look()
        targets = self._targets
        servers, reason = targets
        if not servers:
            on_end(reason)
            return sequence
        self._calls[sequence] = _new_call((set(servers), on_reply, on_end))
        # If the servers have changed since `_targets` was read, `_look` may have missed this call.
        if self._targets is not targets:
            self._look()
        if state.closed:
            self.close_calls()
            return sequence
        writer = self._writer
        result = writer.write(wrap((writer.instance, sequence), payload))
        if result:
            self._refuse(sequence, result)
        if writer.topic in self._local:
            self._context.local_readers.drain(writer.topic)
        return sequence

    def _refuse(self, sequence: int, result: int) -> NoReturn:
        self.cancel(sequence)
        self.state.check()
        error = self._context.library.dds_strretcode(result).decode()
        raise TransportError(f'{self.state.title}: Cyclone DDS refused a request: {error}')

    def cancel(self, sequence: int) -> None:
        """Forget this request."""
        with self._lock:
            self._pop(sequence)

    def _pop(self, sequence: int) -> Call | None:
        self._refusals.pop(sequence, None)
        return self._calls.pop(sequence, None)

    def _servers(self, requested: list[Peer]) -> tuple[frozenset[str], str]:
        """Return the servers that get a request, and the reason if there are none."""
        if any(peer.speaks_fast_dds for peer in requested):
            return frozenset(), _FOREIGN
        return frozenset(peer.server for peer in requested), ''

    def reaches_server(self) -> bool:
        """Return whether a server's reader and writer are both matched (rmw_service_server_is_available)."""
        if not (self._requested and self._answering):
            self._look()
        asked = [peer for peer in self._requested if not peer.speaks_fast_dds]
        ids = {peer.service_id for peer in asked if peer.service_id}
        if not ids:
            return bool(asked and self._answering)
        return any(peer.service_id in ids for peer in self._answering)

    def _look(self) -> None:
        """Look up the matched servers, wake threads that wait for one, and end calls without a server."""
        peers = self._context.peers
        with self._lock:
            before = self._requested, self._answering
            self._requested = peers.subscriptions(self._writer.handle)
            self._answering = peers.publications(self.reader.handle)
            self._targets = self._servers(self._requested)
            changed = before != (self._requested, self._answering)
            there = {peer.server for peer in self._requested}
            if not there:
                self._writer.discard_waiting()
            orphaned = any(call.servers.isdisjoint(there) for call in list(self._calls.values()))
        if orphaned:
            self._dispatcher.drain_own()  # a server may have answered before it went
            self._end_orphans()
        if changed:
            self._context.notifier.connected()

    def _end_orphans(self) -> None:
        ended = []
        with self._lock:
            # Read again: since `_look` read the servers, a call may have gone to a new server.
            there = {peer.server for peer in self._requested}
            for sequence, call in list(self._calls.items()):
                call.servers.intersection_update(there)
                reason = self._refusals.get(sequence, '')
                # If `_pop` returns False, another thread is delivering the last reply and ends the call.
                if not call.servers and self._pop(sequence):
                    ended.append((call, reason))
        for call, reason in ended:
            call.on_end(reason)

    def _on_message(self, message: RawSample) -> None:
        content, sent, publication = message
        try:
            (client, sequence), payload = unwrap(content)
        except RemoteError as error:
            self._context.rejects.add('reply', error, self.state)
            return
        if client != self._writer.instance:
            return  # a reply for another client
        if sequence < 0:  # see service_header.py
            self._answered(-sequence, publication, refusal_reason(payload))
            return
        call = self._calls.get(sequence)
        if call is None:
            return
        call.on_reply(new_sample((payload, sequence, sent, time_ns(), self.gid)))
        peer = self._known.get(publication)
        if peer is None or call.servers != {peer.server}:
            self._answered(sequence, publication)
        # hot path: `_answered` for a call to one server, saves 2 calls (1.2 us) and a lock for each reply.
        elif self._calls.pop(sequence, None) is not None:
            call.on_end(self._refusals.pop(sequence, ''))

    def _answered(self, sequence: int, publication: int, reason: str = '') -> None:
        """Remove the server that has answered or refused from its call; the last server ends the call."""
        peer = self._context.peers.publication(self.reader.handle, publication)
        with self._lock:
            call = self._calls.get(sequence)
            if call is None:
                return
            if peer is not None:
                call.servers.discard(peer.server)
            if reason:
                self._refusals.setdefault(sequence, reason)
            if call.servers:
                return
            reason = self._refusals.get(sequence, '')
            self._pop(sequence)
        call.on_end(reason)

    def close_calls(self) -> None:
        """End every call: the client is closing."""
        with self._lock:
            calls = [call for each in list(self._calls) if (call := self._pop(each)) is not None]
        for call in calls:
            call.on_end('')

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """The gids of the client's readers and writers."""
        return (self.reader.guid,), (self._writer.guid,)


MATCHING_NS = 100_000_000
"""How long a reply waits for its client's reader (as in rmw_cyclonedds)."""
_FROM_FAST_DDS = 'request from Fast DDS'
_REACHED_LIMIT = 10_000


CycloneRequest: TypeAlias = DdsRequest[Peer, Header, bytes]


class CycloneService(DdsServer[Peer, Header, bytes]):
    """A declared service server."""

    write_reply = staticmethod(wrap)
    write_refusal = staticmethod(refusal)

    def __init__(
        self,
        context: CycloneContext,
        new: EndpointBuilder,
        endpoint: Endpoint,
        deliver: Callable[[Request], None],
    ) -> None:
        data = EndpointData(endpoint.type_hash, service_id=context.next_service_id())
        self._context = context
        self._writer = make_writer(context, Role.REPLY, endpoint, data, new.undo)
        self.reader = make_reader(context, Role.REQUEST, endpoint, data, new.undo)
        super().__init__(new.state, self.reader.guid)
        self._deliver = deliver
        self._local = context.local_readers.by_topic
        self._known = context.peers.known
        self._reached: set[str] = set()
        new.take_in(self.reader.topic, ReaderDispatcher(self.reader, new.state.title, self._on_message))

    def _on_message(self, message: RawSample) -> None:
        content, sent, publication = message
        peer = self._known.get(publication) or self._context.peers.publication(
            self.reader.handle, publication
        )
        if peer is None:
            return  # the client has gone
        if peer.speaks_fast_dds:
            if self._context.rejects.count(_FROM_FAST_DDS, self.state.title) == 1:
                self._context.notifier.when_shown(peer.gid, self._warn_of_fast_dds)
            return
        try:
            header, payload = unwrap(content)
        except RemoteError as error:
            self._context.rejects.add('request', error, self.state)
            return
        sample = new_sample((payload, header[1], sent, time_ns(), peer.gid))
        request = DdsRequest(self, peer, header, sample)
        self.waiting[request] = True
        try:
            self._deliver(request)
        except Exception as error:
            report_failure(self.state.title, error)
            request.cancel()

    def _warn_of_fast_dds(self, client: NodeName) -> None:
        log_rejected(
            self.state.logger,
            f'{self.state.title}: a {_FROM_FAST_DDS} was ignored',
            1,
            f"of node '{client.qualified}', which cannot be answered, for its RMW wants "
            f'what libddsc does not send: unset {CHOICE} here',
        )

    def send(self, request: CycloneRequest, reply: bytes) -> None:
        """Send one reply once its client can receive it. A reply that cannot be sent is counted."""
        client = request.client.client_id
        if client and client not in self._reached and not self._reaches(request.client):
            return
        result = self._writer.write(reply)
        if result and not self.state.closed:
            error = self._context.library.dds_strretcode(result).decode()
            self._context.rejects.add('reply', f'Cyclone DDS refused it: {error}', self.state)
        if self._writer.topic in self._local:
            self._context.local_readers.drain(self._writer.topic)

    def _reaches(self, client: Peer) -> bool:
        """Wait until the client's reader is matched with our writer."""
        if not self._wait_for_match(client):
            if self._context.peers.is_matched(self.reader.handle, client.handle):
                self._context.rejects.add('reply', 'its client does not listen to replies', self.state)
            return False
        if len(self._reached) >= _REACHED_LIMIT:
            self._reached.clear()
        self._reached.add(client.client_id)
        return True

    def _is_matched(self, client: Peer) -> bool:
        readers = self._context.peers.subscriptions(self._writer.handle)
        return any(peer.client_id == client.client_id for peer in readers)

    def _wait_for_match(self, client: Peer) -> bool:
        if self._is_matched(client):
            return True
        library, writer = self._context.library, self._writer.handle
        deadline = monotonic_ns() + MATCHING_NS
        waiting = library.dds_create_waitset(self._context.participant.handle)
        library.dds_set_status_mask(writer, PUBLICATION_MATCHED)
        library.dds_waitset_attach(waiting, writer, 1)
        try:
            while not self._is_matched(client):
                left = deadline - monotonic_ns()
                if left <= 0 or not self._context.peers.is_matched(self.reader.handle, client.handle):
                    return False
                library.dds_waitset_wait(waiting, (c_ssize_t * 1)(), 1, left)
                self._context.statuses.reset(writer, PUBLICATION_MATCHED)
            return True
        finally:
            library.dds_delete(waiting)

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """The gids of the server's readers and writers."""
        return (self.reader.guid,), (self._writer.guid,)
