"""Service clients: a writer of requests and a reader of replies, everybody's replies (dds-wire A2, A3)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from threading import Lock
from time import time_ns
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from goalwire.errors import RemoteError, TransportError
from goalwire.transport.contract import ClientPort, Endpoint, Sample, new_sample
from goalwire.transport.dds.configuration import FAST_DDS_SERVICES
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.endpoint_builder import EndpointBuilder
from goalwire.transport.dds.names import Role
from goalwire.transport.dds.peers import Peer
from goalwire.transport.dds.reader_dispatcher import ReaderDispatcher
from goalwire.transport.dds.refusal import refusal_reason
from goalwire.transport.dds.service_ends import make_reader, make_writer
from goalwire.transport.dds.service_header import unwrap, wrap
from goalwire.transport.dds.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED
from goalwire.transport.dds.user_data import EndpointData
from goalwire.transport.dds.wire import RawSample
from goalwire.transport.endpoint import OpenPort

if TYPE_CHECKING:
    from goalwire.transport.dds.fast_dds import Calls as FastDdsCalls

_FOREIGN = (
    'its server runs on Fast DDS, whose services take requests of another form: start it with '
    f'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or set {FAST_DDS_SERVICES}=1 here'
)
_MIXED = (
    'it has servers on Fast DDS and on Cyclone DDS, which take requests of different forms: start all with '
    'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp'
)


class DdsCall(NamedTuple):
    """One request on its way, and the servers that may still answer."""

    servers: set[str]
    on_reply: Callable[[Sample], None]
    on_end: Callable[[str], None]


_new_call: Callable[[tuple[set[str], Callable[[Sample], None], Callable[[str], None]]], DdsCall] = partial(
    tuple.__new__, DdsCall
)
"""Makes one as its class does, without a call of Python code."""


class DdsClient(OpenPort, ClientPort):
    """A declared service client."""

    def __init__(self, context: DdsContext, new: EndpointBuilder, endpoint: Endpoint) -> None:
        data = EndpointData(endpoint.type_hash, client_id=context.next_service_id(), takes_refusals=True)
        self._context = context
        self._writer = make_writer(context, Role.REQUEST, endpoint, data, new.undo)
        self.reader = make_reader(context, Role.REPLY, endpoint, data, new.undo)
        super().__init__(new.state, self._writer.guid)
        self._next_sequence = count(1).__next__
        self._lock = Lock()
        self._calls: dict[int, DdsCall] = {}
        self._refusals: dict[int, str] = {}
        """Why one of several servers has refused a call that others may still answer."""
        self._local = context.local_readers.by_topic
        self._known = context.peers.known
        self._requested: list[Peer] = []
        self._answering: list[Peer] = []
        self._targets: tuple[frozenset[str], str] = frozenset(), ''
        """Who gets a request now, or nobody and why."""
        self._fast_dds = (
            None if context.translation is None else context.translation.add(self._writer, self.reader)
        )
        if context.translation is not None:
            new.undo.append(partial(context.translation.remove, self._writer))
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
        # What has changed since it was read above may have missed this call.
        if self._targets is not targets:
            self._look()
        if state.closed:
            self.close_calls()
            return sequence
        writer = self._writer
        if self._fast_dds is None:
            result = writer.write(wrap((writer.instance, sequence), payload))
        else:
            result = self._send_translated(self._fast_dds, sequence, payload)
        if result:
            self._refused(sequence, result)
        if writer.topic in self._local:
            self._context.local_readers.drain(writer.topic)
        return sequence

    def _refused(self, sequence: int, result: int) -> NoReturn:
        self.cancel(sequence)
        self.state.check()
        error = self._context.library.dds_strretcode(result).decode()
        raise TransportError(f'{self.state.title}: Cyclone DDS refused a request: {error}')

    def cancel(self, sequence: int) -> None:
        """Hold nothing for this request any more."""
        with self._lock:
            self._pop(sequence)

    def _pop(self, sequence: int) -> DdsCall | None:
        if self._fast_dds is not None:
            self._fast_dds.end(sequence)
        self._refusals.pop(sequence, None)
        return self._calls.pop(sequence, None)

    def _send_translated(self, calls: FastDdsCalls, sequence: int, payload: bytes) -> int:
        """Write a request in the form that its servers take; return 0 or the library's error."""
        if self._requested[0].speaks_fast_dds:
            return calls.write(payload, sequence)
        return calls.write(wrap((self._writer.instance, sequence), payload))

    def _servers(self, requested: list[Peer]) -> tuple[frozenset[str], str]:
        """Return who of these gets a request, or nobody and why."""
        foreign = [peer for peer in requested if peer.speaks_fast_dds]
        if foreign and self._fast_dds is None:
            return frozenset(), _FOREIGN
        if foreign and len(foreign) < len(requested):
            return frozenset(), _MIXED
        return frozenset(peer.server for peer in requested), ''

    def reaches_server(self) -> bool:
        """Whether both ends of a server are matched with ours (rmw_service_server_is_available)."""
        if not (self._requested and self._answering):
            self._look()
        calls_all = self._fast_dds is not None
        asked = [peer for peer in self._requested if calls_all or not peer.speaks_fast_dds]
        ids = {peer.service_id for peer in asked if peer.service_id}
        if not ids:
            return bool(asked and self._answering)
        return any(peer.service_id in ids for peer in self._answering)

    def _look(self) -> None:
        """See who is matched, tell who waits for that, and end the calls that nobody can answer now."""
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
            self._dispatcher.drain_own()  # a server that has gone may have answered before
            self._end_orphans()
        if changed:
            self._context.notifier.connected()

    def _end_orphans(self) -> None:
        ended = []
        with self._lock:
            there = {peer.server for peer in self._requested}  # as it is now: a new one may have been called
            for sequence, call in list(self._calls.items()):
                call.servers.intersection_update(there)
                reason = self._refusals.get(sequence, '')
                if not call.servers and self._pop(sequence):  # else its last reply is just being told
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
            return  # another client's
        if sequence < 0:  # see refusal.py
            self._answered(-sequence, publication, refusal_reason(payload))
            return
        call = self._calls.get(sequence)
        if call is None:
            return
        call.on_reply(new_sample((payload, sequence, sent, time_ns(), self.gid)))
        peer = self._known.get(publication)
        if peer is None or self._fast_dds is not None or call.servers != {peer.server}:
            self._answered(sequence, publication)
        elif self._calls.pop(sequence, None) is not None:  # what `_answered` does where only one was asked
            call.on_end(self._refusals.pop(sequence, ''))

    def _answered(self, sequence: int, publication: int, reason: str = '') -> None:
        """Cross the server off that has just answered or refused; the last one ends the call."""
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
        """What it reads and writes with."""
        return (self.reader.guid,), (self._writer.guid,)
