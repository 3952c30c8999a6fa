"""Discovery: finds other participants, and their writers and readers.

Participants announce themselves to addresses that are configured (SPDP). Then each tells the other of its
writers and readers (SEDP), by built-in writers and readers. Both sides send their data
as soon as they know each other, so that a match takes one exchange.

An announcement can be forged. So a participant on another host gets no more bytes than its announcement had,
until it has proved, by naming this participant's GUID, that it reads packets at its addresses. A packet in a
participant's name counts only if it comes from one of its hosts.
"""

from __future__ import annotations

from functools import partial

from goalwire.records import record
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol import parameters as pids
from goalwire.rtps.protocol.announcements import (
    EndpointData,
    ParticipantData,
    read_endpoint,
    read_key,
    read_participant,
    write_endpoint,
    write_key,
    write_participant,
)
from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.matching import Matching, RemoteParticipant
from goalwire.rtps.protocol.messages import HEADER_SIZE, Data, info_dst, info_ts
from goalwire.rtps.protocol.primitives import (
    MESSAGE_READER,
    MESSAGE_WRITER,
    NS,
    PARTICIPANT,
    PREFIX_SIZE,
    PUBLICATIONS_READER,
    PUBLICATIONS_WRITER,
    SPDP_READER,
    SPDP_WRITER,
    SUBSCRIPTIONS_READER,
    SUBSCRIPTIONS_WRITER,
    UNKNOWN_PREFIX,
    Address,
    RtpsError,
    encode_time,
    is_writer,
)
from goalwire.rtps.protocol.wire import Timer, Watch, Wire
from goalwire.rtps.protocol.writer import Writer

FIRST_ANNOUNCEMENTS = 6
FIRST_ANNOUNCEMENTS_S = 0.1
"""How often a participant announces itself at the start, and when its addresses have changed."""

ANSWERED_S = FIRST_ANNOUNCEMENTS_S / 2
"""How long one answer is enough: the same announcement comes by several addresses."""
SETTLED_S = 1.0
"""How long after a meeting answers still belong to it, and do not mean that the other was restarted."""

BUILTIN = (
    (0x04, 0x08, PUBLICATIONS_WRITER, PUBLICATIONS_READER),
    (0x10, 0x20, SUBSCRIPTIONS_WRITER, SUBSCRIPTIONS_READER),
    (0x400, 0x800, MESSAGE_WRITER, MESSAGE_READER),
)
"""For each pair of built-in endpoints: the bits that announce the writer and the
reader, and their entity ids."""
GONE = pids.DISPOSED | pids.UNREGISTERED


@record
class Settings:
    """The settings of a participant."""

    prefix: bytes
    domain: int = 0
    metatraffic: tuple[Address, ...] = ()
    default: tuple[Address, ...] = ()
    """The addresses of this participant: for discovery, and for data."""
    peers: tuple[Address, ...] = ()
    """The addresses that get its announcements."""
    own_hosts: frozenset[str] = frozenset({'127.0.0.1'})
    """The addresses of this host."""
    lease: int = 20 * NS
    user_data: bytes = b''
    name: str = ''
    tag: str = ''
    announce_s: float = 3.0
    """How often it announces itself."""
    packet_size: int | None = None
    """The largest packet in bytes; None: chosen for readers on this host and on others."""
    ipv6: bool = False
    """True if its sockets use IPv6; locators of the other kind are skipped."""
    receive_buffer: int = 0
    """How many bytes of unread packets the system keeps for its data socket; 0: unknown."""


class ParticipantListener:
    """The callbacks of discovery. Every method is called without any lock held."""

    def on_participant(self, participant: ParticipantData) -> None:
        """Called when a participant has appeared, or has changed its data."""

    def on_participant_lost(self, participant: ParticipantData) -> None:
        """Called when a participant has left or its lease has ended, after its endpoints were lost."""

    def on_endpoint(self, endpoint: EndpointData) -> None:
        """Called when another participant's writer or reader has appeared, or has changed its data."""

    def on_endpoint_lost(self, endpoint: EndpointData) -> None:
        """Called when another participant's writer or reader has disappeared."""

    def on_refused(self, kind: str, reason: str) -> None:
        """Called when received data is ignored because it breaks the rules or exceeds a bound."""


class Discovery:
    """The discovery of one participant: sends and reads SPDP and SEDP.

    Methods are called inside `Wire.run`.
    """

    def __init__(
        self,
        wire: Wire,
        settings: Settings,
        own: ParticipantData,
        listener: ParticipantListener,
        known: Matching,
    ) -> None:
        self._wire = wire
        self._settings = settings
        self._own = own
        self._listener = listener
        self._known = known
        self._strangers: dict[bytes, None] = {}
        """Participants that have proved nothing yet, the oldest first."""
        self._announcement = self._announce_as(0)
        self._timer: Timer | None = None
        self._is_closed = False

    # ---- the participant itself

    def announce(self, left: int = FIRST_ANNOUNCEMENTS) -> None:
        """Announce the participant now and periodically: `left` times in quick succession, then seldom."""
        if self._is_closed:
            return
        self._send_to_all(self._announcement_to(UNKNOWN_PREFIX))
        delay = FIRST_ANNOUNCEMENTS_S if left > 1 else self._settings.announce_s
        self._timer = self._wire.timers.at(self._wire.clock() + delay, partial(self.announce, left - 1))

    def move(self, own: ParticipantData, settings: Settings) -> None:
        """Change the participant's own addresses and those that get announcements; announce it anew."""
        self._own, self._settings = own, settings
        self._known.move(own, settings.own_hosts)
        self._announcement = self._announce_as(0)
        if self._timer is not None:
            self._timer.cancel()
            self.announce()

    def _send_to_all(self, packet: bytes) -> None:
        """Send a packet to the configured addresses, and to all participants that are known."""
        addresses = dict.fromkeys(self._settings.peers)
        for remote in self._known.remotes.values():
            if remote.is_reached and remote is not self._known.own:
                addresses[remote.address] = None
        for address in addresses:
            self._wire.send(packet, address)

    def _announce_as(self, status: int) -> bytes:
        """Return a packet of SPDP that says that the participant exists (status 0), or that it leaves."""
        guid = self._wire.prefix + PARTICIPANT
        if status:
            qos, payload = pids.write_status(status, guid), write_key(pids.PARTICIPANT_GUID, guid)
        else:
            qos, payload = b'', write_participant(self._own)
        data = Data(SPDP_READER, SPDP_WRITER, 1 + bool(status), qos, payload, is_key=bool(status))
        return self._wire.head + info_ts(encode_time(self._wire.wall_clock_ns())) + data.encode()

    def _announcement_to(self, prefix: bytes) -> bytes:
        """Return the announcement for the participant `prefix`, or for all.

        Both packets have the same size.
        """
        return self._wire.head + info_dst(prefix) + self._announcement[HEADER_SIZE:]

    def _answer(self, remote: RemoteParticipant, size: int) -> None:
        """Answer the announcement of another participant, which came in a packet of `size` bytes."""
        now = self._wire.clock()
        answer = self._announcement_to(remote.data.prefix)
        if now >= remote.answered_at + ANSWERED_S and (remote.is_near or len(answer) <= size):
            remote.answered_at = now
            self._wire.send(answer, remote.address)

    def leave(self) -> None:
        """Tell the other participants that this one leaves, and forget them."""
        self._is_closed = True
        self._send_to_all(self._announce_as(GONE))
        for remote in self._known.remotes.values():
            if remote.watch is not None:
                remote.watch.stop()

    def tell(self, endpoint: EndpointData) -> None:
        """Tell all participants of a writer or a reader of this participant."""
        self._teller(endpoint.guid).add(write_endpoint(endpoint), key=endpoint.guid)

    def tell_gone(self, guid: bytes) -> None:
        """Tell all participants that a writer or a reader of this participant has gone."""
        key = write_key(pids.ENDPOINT_GUID, guid)
        self._teller(guid).add(key, pids.write_status(GONE, guid), key=guid, is_key=True)

    def _teller(self, guid: bytes) -> Writer:
        is_writers = is_writer(guid[PREFIX_SIZE:])
        return self._known.writers[PUBLICATIONS_WRITER if is_writers else SUBSCRIPTIONS_WRITER]

    # ---- participants

    def on_announcement(self, data: Data, prefix: bytes, source: Address, size: int, is_named: bool) -> None:
        """Take an announcement (SPDP) of a participant, in a packet of `size` bytes.

        `is_named`: the announcement is an answer that names this participant.
        """
        status = pids.status_of(data.qos)[0] if data.qos else 0
        remote = self._known.remotes.get(prefix)
        if status & (GONE):
            if remote is not None and remote is not self._known.own:
                self._lose(remote)
            return
        if data.payload is None or data.is_key:
            return
        told = read_participant(data.payload)
        own = self._own
        if told.prefix != prefix:
            raise RtpsError('a participant announces another one')
        if (told.domain is not None and told.domain != own.domain) or told.tag != own.tag:
            return
        if bounds.MOST_LOCATORS in (len(told.metatraffic), len(told.default)):
            self._wire.refuse('locator', f'a participant tells {bounds.MOST_LOCATORS} or more')
        if remote is None:
            self._meet(told, source, size, is_named)
            return
        if not (remote.is_proven or is_named):
            self._answer(remote, size)
        elif is_named and remote.is_reached and self._wire.clock() > remote.reached_at + SETTLED_S:
            self._remind(remote)
        if remote.data != told and remote is not self._known.own:
            self._follow(remote, told, source[0], is_named=is_named)

    def _meet(self, told: ParticipantData, source: Address, size: int, is_named: bool) -> None:
        """Add a participant that has announced itself."""
        own_hosts = self._settings.own_hosts
        known = self._known
        address = known.choose(told.metatraffic, source[0]) or known.first(told.metatraffic)
        if address is None:
            self._wire.refuse('participant without address', source[0])
            return
        if len(self._known.remotes) - len(self._strangers) > bounds.MOST_PARTICIPANTS:
            self._wire.refuse('participant', f'{bounds.MOST_PARTICIPANTS} are known')
            return
        while len(self._strangers) >= bounds.MOST_STRANGERS:
            self._wire.refuse('participant', f'{bounds.MOST_STRANGERS} newer ones have shown nothing yet')
            self._lose(self._known.remotes[next(iter(self._strangers))])
        is_near = source[0] in own_hosts and address[0] in own_hosts
        remote = RemoteParticipant(told, self._hosts_of(told, source[0]), address, is_near)
        self._known.remotes[told.prefix] = remote
        self._strangers[told.prefix] = None
        lease = min(told.lease / NS, bounds.LONGEST_LEASE_S)
        remote.watch = Watch(self._wire, max(lease, 0.1), partial(self._lose, remote))
        self._wire.tell(self._listener.on_participant, told)
        self._answer(remote, size)
        if is_near:
            self._reach(remote)
        if is_named:
            self.prove(remote, source[0])

    def _hosts_of(self, told: ParticipantData, source: str) -> set[str]:
        """Return the hosts from which packets in a participant's name are accepted."""
        own_hosts = self._settings.own_hosts
        hosts = {source, *(host for host, _ in (*told.metatraffic, *told.default))}
        return hosts | own_hosts if source in own_hosts else hosts

    def _follow(
        self, remote: RemoteParticipant, told: ParticipantData, source: str, *, is_named: bool
    ) -> None:
        """Record a participant's changed data, and send to its new addresses.

        The host to which packets go stays the same, unless the participant names this one in a packet from
        another host.
        """
        known = self._known
        address = known.choose(told.metatraffic, remote.address[0])
        if address is None and (is_named or not remote.is_reached):
            address = known.choose(told.metatraffic, source)
        if address is None:
            self._wire.refuse('announcement of another host', source)
            return
        remote.data, remote.address = told, address
        remote.hosts = self._hosts_of(told, source)
        remote.sources.clear()
        remote.addresses.clear()
        known.follow(remote)
        self._wire.tell(self._listener.on_participant, told)

    def prove(self, remote: RemoteParticipant, host: str) -> None:
        """Note that a participant named this one, which proves that it reads packets at `host`."""
        if not remote.is_near and host != remote.address[0]:
            address = self._known.choose(remote.data.metatraffic, host)
            if address is None:
                self._wire.refuse('participant that tells no address on its host', host)
                return
            remote.address = address
        remote.is_proven = True
        self._strangers.pop(remote.data.prefix, None)
        self._reach(remote)

    def _reach(self, remote: RemoteParticipant) -> None:
        """Match the built-in endpoints of this and another participant: then both learn of all endpoints."""
        if remote.is_reached:
            return
        remote.is_reached, remote.reached_at = True, self._wire.clock()
        prefix, has = remote.data.prefix, remote.data.endpoints
        for writer_bit, reader_bit, writer_id, reader_id in BUILTIN:
            qos = self._known.writers[writer_id].data.qos
            if has & reader_bit:
                reader = EndpointData(prefix + reader_id, '', '', qos)
                self._known.writers[writer_id].match(
                    reader, remote.address, is_near=remote.is_near, pushes=True
                )
            if has & writer_bit:
                writer = EndpointData(prefix + writer_id, '', '', qos)
                self._known.route(self._known.readers[reader_id], writer, remote.address)

    def _remind(self, remote: RemoteParticipant) -> None:
        """Answer a participant that has lost this one meanwhile and now meets it anew.

        The answer names that participant, which proves that this one reads packets at its address, and makes
        that participant request all endpoints again.
        """
        for _, _, writer_id, reader_id in BUILTIN:
            self._known.writers[writer_id].tell_again(remote.data.prefix + reader_id)

    def _lose(self, remote: RemoteParticipant) -> None:
        """Forget another participant and its endpoints."""
        prefix = remote.data.prefix
        if self._known.remotes.pop(prefix, None) is None:
            return
        self._strangers.pop(prefix, None)
        if remote.watch is not None:
            remote.watch.stop()
        for guid in list(remote.endpoints):
            self._lose_endpoint(remote, guid)
        for _, _, writer_id, reader_id in BUILTIN:
            self._known.writers[writer_id].unmatch(prefix + reader_id)
            self._known.unroute(prefix + writer_id, reader_id)
        self._wire.tell(self._listener.on_participant_lost, remote.data)

    # ---- other participants' writers and readers

    def on_endpoint(self, sample: Sample, *, are_writers: bool) -> RemoteParticipant | None:
        """Take news of a writer or a reader (SEDP): it exists, or has gone. Raises RtpsError.

        Returns the participant of the endpoint if the endpoint is a writer, else None.
        """
        remote = self._known.remotes.get(sample.writer[:PREFIX_SIZE])
        if remote is None:
            return None
        status, key = pids.status_of(sample.qos) if sample.qos else (0, b'')
        if status & GONE:
            guid = key or (read_key(bytes(sample.payload), pids.ENDPOINT_GUID) if sample.payload else None)
            if guid is not None:
                self._lose_endpoint(remote, guid)
            return None
        if sample.payload is None or sample.is_key:
            return None
        endpoint = read_endpoint(bytes(sample.payload))
        if endpoint.prefix != remote.data.prefix or is_writer(endpoint.entity_id) is not are_writers:
            raise RtpsError('an endpoint is told of by a participant that it does not belong to')
        size = len(sample.payload)
        if len(endpoint.addresses) == bounds.MOST_LOCATORS:
            self._wire.refuse('locator', f'an endpoint tells {bounds.MOST_LOCATORS} or more')
        if not self._known.has_room(remote, endpoint.guid, size):
            return None
        if self._known.take(remote, endpoint, size):
            self._wire.tell(self._listener.on_endpoint, endpoint)
        return remote if are_writers else None

    def _lose_endpoint(self, remote: RemoteParticipant, guid: bytes) -> None:
        endpoint = self._known.lose(remote, guid)
        if endpoint is not None:
            self._wire.tell(self._listener.on_endpoint_lost, endpoint)
