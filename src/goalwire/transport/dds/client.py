"""Service clients: a writer of requests and a reader of replies, everybody's replies (dds-wire A2, A3)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from threading import Lock
from time import time_ns

from goalwire.errors import RemoteError, TransportError
from goalwire.transport.contract import ClientPort, Endpoint, Sample
from goalwire.transport.dds.core import Core
from goalwire.transport.dds.declaring import Declaration
from goalwire.transport.dds.intake import Intake
from goalwire.transport.dds.names import Role
from goalwire.transport.dds.peers import Peer
from goalwire.transport.dds.service_ends import make_reader, make_writer
from goalwire.transport.dds.service_header import Header, unwrap, wrap
from goalwire.transport.dds.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED
from goalwire.transport.dds.user_data import EndpointData
from goalwire.transport.dds.wire import Taken

_FOREIGN = (
    'its server runs on Fast DDS, whose services Cyclone DDS cannot call: start it with '
    'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp'
)


class Call:
    """One request on its way, and the servers that may still answer."""

    __slots__ = ('on_end', 'on_reply', 'servers')

    def __init__(
        self, servers: set[str], on_reply: Callable[[Sample], None], on_end: Callable[[str], None]
    ) -> None:
        self.servers = servers
        self.on_reply = on_reply
        self.on_end = on_end


class DdsClient(ClientPort):
    """A declared service client."""

    def __init__(self, core: Core, new: Declaration, endpoint: Endpoint) -> None:
        data = EndpointData(endpoint.type_hash, client_id=core.next_service_id())
        self._core = core
        self._place = new.place
        self._writer = make_writer(core, Role.REQUEST, endpoint, data, new.undo)
        self.reader = make_reader(core, Role.REPLY, endpoint, data, new.undo)
        self.gid = self._writer.guid
        self._next_sequence = count(1).__next__
        self._lock = Lock()
        self._calls: dict[int, Call] = {}
        self._requested: list[Peer] = []
        self._answering: list[Peer] = []
        new.undo.callback(self.end_all)
        new.take_in(self.reader.topic, Intake(self.reader, new.place.title, self._on_message))
        core.statuses.watch(self._writer.handle, PUBLICATION_MATCHED, self._look)
        core.statuses.watch(self.reader.handle, SUBSCRIPTION_MATCHED, self._look)

    def request(
        self, payload: bytes, on_reply: Callable[[Sample], None], on_end: Callable[[str], None]
    ) -> int:
        """Send one request to every server."""
        self._place.check()
        sequence = self._next_sequence()
        servers, reason = self._servers()
        if not servers:
            on_end(reason)
            return sequence
        with self._lock:
            self._calls[sequence] = Call(servers, on_reply, on_end)
        if self._place.closed:  # since the check above: closing may have missed this call
            self.end_all()
            return sequence
        result = self._writer.write(wrap(Header(self._writer.instance, sequence), payload))
        if result:
            with self._lock:
                self._calls.pop(sequence, None)
            self._place.check()
            error = self._core.library.dds_strretcode(result).decode()
            raise TransportError(f'{self._place.title}: Cyclone DDS refused a request: {error}')
        self._core.intakes.drain(self._writer.topic)
        return sequence

    def forget(self, sequence: int) -> None:
        """Hold nothing for this request any more."""
        with self._lock:
            self._calls.pop(sequence, None)

    def _servers(self) -> tuple[set[str], str]:
        """Return who gets a request now, or nobody and why."""
        if not self._requested:
            self._look()
        requested = self._requested
        if any(peer.speaks_fast_dds for peer in requested):
            return set(), _FOREIGN
        return {peer.server for peer in requested}, ''

    def reaches_server(self) -> bool:
        """Whether both ends of a server are matched with ours (rmw_service_server_is_available)."""
        if not (self._requested and self._answering):
            self._look()
        asked = [peer for peer in self._requested if not peer.speaks_fast_dds]
        ids = {peer.service_id for peer in asked if peer.service_id}
        if not ids:
            return bool(asked and self._answering)
        return any(peer.service_id in ids for peer in self._answering)

    def _look(self) -> None:
        """See who is matched, tell who waits for that, and end the calls that nobody can answer now."""
        peers = self._core.peers
        with self._lock:
            before = self._requested, self._answering
            self._requested = peers.subscriptions(self._writer.handle)
            self._answering = peers.publications(self.reader.handle)
            changed = before != (self._requested, self._answering)
            there = {peer.server for peer in self._requested}
            ended = []
            for sequence, call in list(self._calls.items()):
                call.servers &= there
                if not call.servers:
                    ended.append(self._calls.pop(sequence))
        for call in ended:
            call.on_end('')
        if changed:
            self._core.feed.connected()

    def _on_message(self, message: Taken) -> None:
        try:
            header, payload = unwrap(message.payload)
        except RemoteError as error:
            self._core.rejects.add('reply', f'{self._place.title}: {error}')
            return
        if header.client != self._writer.instance:
            return  # another client's
        call = self._calls.get(header.sequence)
        if call is None:
            return
        call.on_reply(Sample(payload, header.sequence, message.source_timestamp, time_ns(), self.gid))
        peer = self._core.peers.publication(self.reader.handle, message.publication)
        with self._lock:
            if peer is not None:
                call.servers.discard(peer.server)
            is_last = not call.servers and self._calls.pop(header.sequence, None) is not None
        if is_last:
            call.on_end('')

    def end_all(self) -> None:
        """End every call: the client is closing."""
        with self._lock:
            calls = list(self._calls.values())
            self._calls.clear()
        for call in calls:
            call.on_end('')

    @property
    def gids(self) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
        """What it reads and writes with."""
        return (self.reader.guid,), (self._writer.guid,)

    def close(self) -> None:
        """Undeclare and end every call."""
        self._place.give_up()
