"""Service servers: a reader of requests and a writer of replies, which go to all clients (dds-wire A2)."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_ssize_t
from time import monotonic_ns, time_ns

from goalwire.errors import LocalError, RemoteError
from goalwire.transport.contract import Endpoint, NodeName, Request, Sample, new_sample
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.endpoint_builder import EndpointBuilder
from goalwire.transport.dds.names import Role
from goalwire.transport.dds.peers import Peer
from goalwire.transport.dds.reader_dispatcher import ReaderDispatcher
from goalwire.transport.dds.refusal import refusal
from goalwire.transport.dds.service_ends import make_reader, make_writer
from goalwire.transport.dds.service_header import Header, unwrap, wrap
from goalwire.transport.dds.status import PUBLICATION_MATCHED
from goalwire.transport.dds.user_data import EndpointData
from goalwire.transport.dds.wire import RawSample
from goalwire.transport.endpoint import OpenPort
from goalwire.transport.reports import log_rejected, report_failure

MATCHING_NS = 100_000_000
"""How long a reply waits for its client's reader (as in rmw_cyclonedds)."""
_FROM_FAST_DDS = 'request from Fast DDS'
_REACHED_LIMIT = 10_000


class DdsRequest(Request):
    """One request waiting for its reply."""

    __slots__ = ('_header', '_is_answered', '_service', 'client', 'sample', 'writer')

    def __init__(
        self, service: DdsService, header: Header, client: Peer, writer: int, sample: Sample
    ) -> None:
        self.sample = sample
        self.client = client
        self.writer = writer
        """The instance handle of the client's request writer."""
        self._service = service
        self._header = header
        self._is_answered = False

    def reply(self, payload: bytes) -> None:
        """Answer. Raises LocalError the second time, ForkedError after a fork."""
        service = self._service
        state = service.state
        if state.guard.is_forked:
            state.check()
        if self._is_answered:
            raise LocalError(f'{state.title}: this request was answered before; answer it once')
        self._is_answered = True
        if service.waiting.pop(self, False):
            service.send(self, wrap(self._header, payload))

    def cancel(self, reason: str = '') -> None:
        """End the request. A client that is not goalwire's is not told: its call ends with the server."""
        service = self._service
        if service.state.is_forked:
            service.state.check()
        if service.waiting.pop(self, False) and self.client.takes_refusals:
            service.send(self, refusal(self._header, reason))


class DdsService(OpenPort):
    """A declared service server."""

    def __init__(
        self,
        context: DdsContext,
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
        self.waiting: dict[DdsRequest, bool] = {}
        """The requests that are neither answered nor cancelled: True for who takes one out.

        Closing clears it: who has sent them learns of the server's end from the graph.
        """
        self._local = context.local_readers.by_topic
        self._known = context.peers.known
        self._reached: set[str] = set()
        new.undo.append(self.waiting.clear)
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
        request = DdsRequest(self, header, peer, publication, sample)
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
            'what Cyclone DDS does not send: start both with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp',
        )

    def send(self, request: DdsRequest, reply: bytes) -> None:
        """Send one reply, once its client can hear it; what cannot be sent is counted."""
        client = request.client.client_id
        if client and client not in self._reached and not self._reaches(client, request.writer):
            return
        result = self._writer.write(reply)
        if result and not self.state.closed:
            error = self._context.library.dds_strretcode(result).decode()
            self._context.rejects.add('reply', f'Cyclone DDS refused it: {error}', self.state)
        if self._writer.topic in self._local:
            self._context.local_readers.drain(self._writer.topic)

    def _reaches(self, client: str, request_writer: int) -> bool:
        """Wait until the client's reader is matched with our writer."""
        if not self._wait_for_match(client, request_writer):
            if self._context.peers.is_matched(self.reader.handle, request_writer):
                self._context.rejects.add('reply', 'its client does not listen to replies', self.state)
            return False
        if len(self._reached) >= _REACHED_LIMIT:
            self._reached.clear()
        self._reached.add(client)
        return True

    def _is_matched(self, client: str) -> bool:
        readers = self._context.peers.subscriptions(self._writer.handle)
        return any(peer.client_id == client for peer in readers)

    def _wait_for_match(self, client: str, request_writer: int) -> bool:
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
                if left <= 0 or not self._context.peers.is_matched(self.reader.handle, request_writer):
                    return False
                library.dds_waitset_wait(waiting, (c_ssize_t * 1)(), 1, left)
                self._context.statuses.reset(writer, PUBLICATION_MATCHED)
            return True
        finally:
            library.dds_delete(waiting)

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """What it reads and writes with."""
        return (self.reader.guid,), (self._writer.guid,)
