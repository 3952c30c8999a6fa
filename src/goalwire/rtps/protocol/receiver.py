"""Hands the contents of received packets to the participant's writers, readers and discovery."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.discovery import Discovery
from goalwire.rtps.protocol.identity import may_come_from
from goalwire.rtps.protocol.matching import Matching, RemoteParticipant
from goalwire.rtps.protocol.messages import (
    DATA,
    HEADER_SIZE,
    INFO_DST,
    INFO_SRC,
    INFO_TS,
    INVALIDATE,
    LITTLE,
    MAGIC,
    TIME,
    VERSION,
    AckNack,
    Data,
    DataFrag,
    Gap,
    Heartbeat,
    HeartbeatFrag,
    NackFrag,
    check_header,
    read_body,
    split,
)
from goalwire.rtps.protocol.plain_packet import read_plain, read_plain_fragments
from goalwire.rtps.protocol.primitives import (
    LARGE,
    PREFIX_SIZE,
    SPDP_WRITER,
    UNKNOWN_ENTITY,
    UNKNOWN_PREFIX,
    Address,
    RtpsError,
    decode_time,
)
from goalwire.rtps.protocol.reader import Reader, WriterProxy
from goalwire.rtps.protocol.wire import Wire

_BEGIN = MAGIC + VERSION[:1]


class Receiver:
    """Reads the packets that one participant receives. Methods are called inside `Wire.run`."""

    def __init__(self, wire: Wire, known: Matching, discovery: Discovery) -> None:
        self._wire = wire
        self._prefix = wire.prefix
        self._known = known
        self._discovery = discovery
        self._early_size = 0
        """Bytes of the packets whose writers are not known yet."""
        self.is_closed = False
        """True if packets are ignored: the participant's sockets will be closed in a moment."""

    def receive(self, packet: bytes | memoryview, source: Address) -> None:
        """Take a packet from an address.

        If the packet is a memoryview, its memory is not used after the return.
        """
        if self.is_closed:
            return
        try:
            if len(packet) > LARGE and self._read_fragments(packet, source):
                return
            packet = bytes(packet)
            if not packet.startswith(_BEGIN):
                check_header(packet)
            prefix = packet[8:HEADER_SIZE]
            remote = self._known.remotes.get(prefix)
            if remote is None:
                if self._is_from(prefix, None, source):
                    self._read_stranger(packet, prefix, source)
            elif source in remote.sources or self._is_from(prefix, remote, source):
                if remote.watch is not None:
                    remote.watch.heard = self._wire.clock()
                # hot path: plain packets' samples go to the readers from here, which saves a call for each
                plain = read_plain(packet, prefix, self._prefix) if remote.is_proven else None
                routes = self._known.routes.get(plain[1].writer) if plain is not None else None
                if plain is None or routes is None:
                    self._read(packet, prefix, source, remote)
                    return
                for reader, proxy in routes:
                    if plain[0] in (UNKNOWN_ENTITY, reader.entity_id):
                        reader.on_sample(proxy, plain[1])
        except RtpsError as error:
            self._wire.refuse('malformed packet', str(error))

    def receive_all(self, packets: Iterable[tuple[bytes | memoryview, Address]]) -> None:
        """Take several packets, each from an address."""
        for packet, source in packets:
            self.receive(packet, source)

    def _read_fragments(self, packet: bytes | memoryview, source: Address) -> bool:
        """Copy the fragments of a plain packet out of its memory; False if `_read` has to read the packet."""
        prefix = bytes(packet[8:HEADER_SIZE])
        remote = self._known.remotes.get(prefix)
        if remote is None or not remote.is_proven or source not in remote.sources:
            return False
        plain = read_plain_fragments(memoryview(packet), self._prefix)
        if plain is None or packet[: len(_BEGIN)] != _BEGIN:
            return False
        fragments, time = plain
        routes = self._known.routes.get(prefix + fragments.writer)
        if routes is None:
            return False
        if remote.watch is not None:
            remote.watch.heard = self._wire.clock()
        for reader, proxy in routes:
            if fragments.reader in (UNKNOWN_ENTITY, reader.entity_id):
                reader.on_fragment(proxy, fragments, time)
        return True

    # ---- who speaks

    def _is_from(self, prefix: bytes, remote: RemoteParticipant | None, source: Address) -> bool:
        """Return True if a participant's packet may come from an address; else count the refusal."""
        host, port = source
        if remote is not None and host not in remote.hosts:
            if remote is not self._known.own:
                self._wire.refuse('packet in the name of another host', host)
            return False
        if host in self._known.own_hosts and not may_come_from(prefix, port):
            self._wire.refuse('packet in the name of another program', f'{host}:{port}')
            return False
        if remote is not None:
            if len(remote.sources) >= bounds.MOST_ADDRESSES:
                remote.sources.clear()
            remote.sources.add(source)
        return True

    def _read_stranger(self, packet: bytes, prefix: bytes, source: Address) -> None:
        """Look for an announcement in the packet of an unknown participant."""
        is_for_us, is_named = True, False
        for kind, flags, at, end in split(packet):
            if kind == INFO_DST:
                is_named = packet[at:end] == self._prefix
                is_for_us = is_named or packet[at:end] == UNKNOWN_PREFIX
            elif kind == DATA and is_for_us:
                data = Data.read(packet, at, end, flags) if end - at >= 20 else None
                if data is not None and data.writer == SPDP_WRITER:
                    self._discovery.on_announcement(data, prefix, source, len(packet), is_named)

    # ---- the submessages

    def _read(self, packet: bytes, prefix: bytes, source: Address, remote: RemoteParticipant) -> None:
        """Read any packet of a known participant, submessage by submessage."""
        time: int | None = None
        whom = UNKNOWN_PREFIX
        is_for_us = True
        is_early = False
        routes = self._known.routes
        for kind, flags, at, end in split(packet):
            if kind == INFO_DST:
                whom = packet[at : at + PREFIX_SIZE]
                is_for_us = whom in (self._prefix, UNKNOWN_PREFIX)
                if whom == self._prefix and not remote.is_proven:
                    self._discovery.prove(remote, source[0])
                continue
            if kind == INFO_TS:
                time = None
                if not flags & INVALIDATE and end - at >= 8:
                    time = decode_time(*TIME[flags & LITTLE].unpack_from(packet, at))
                continue
            if kind == INFO_SRC:
                return  # the following submessages are another participant's, which no implementation sends
            body = read_body(kind, packet, at, end, flags) if is_for_us else None
            if body is None:
                continue
            if isinstance(body, (AckNack, NackFrag)):
                self._to_writer(prefix, body)
                continue
            readers = routes.get(prefix + body.writer)
            if readers is None:
                if isinstance(body, Data) and body.writer == SPDP_WRITER:
                    self._discovery.on_announcement(body, prefix, source, len(packet), whom == self._prefix)
                elif body.writer[3] & 0xC0 == 0:
                    is_early = True
                continue
            addressee = body.reader
            for reader, proxy in tuple(readers):
                if addressee in (UNKNOWN_ENTITY, reader.entity_id):
                    self._to_reader(reader, proxy, body, time)
        if is_early and prefix != self._prefix:
            self._keep_early(remote, packet, source)

    @staticmethod
    def _to_reader(
        reader: Reader,
        proxy: WriterProxy,
        body: Data | DataFrag | Heartbeat | Gap | HeartbeatFrag,
        time: int | None,
    ) -> None:
        if isinstance(body, Data):
            guid = proxy.data.guid
            reader.on_sample(proxy, Sample(guid, body.number, time, body.payload, body.qos, body.is_key))
        elif isinstance(body, Heartbeat):
            reader.on_heartbeat(proxy, body)
        elif isinstance(body, DataFrag):
            reader.on_fragment(proxy, body, time)
        elif isinstance(body, Gap):
            reader.on_gap(proxy, body)
        else:
            reader.on_heartbeat_frag(proxy, body)

    def _to_writer(self, prefix: bytes, body: AckNack | NackFrag) -> None:
        writer = self._known.writers.get(body.writer)
        proxy = None if writer is None else writer.readers.get(prefix + body.reader)
        if writer is None or proxy is None:
            return
        if isinstance(body, AckNack):
            writer.on_acknack(proxy, body)
        else:
            writer.on_nack_frag(proxy, body)

    # ---- packets whose writers are not known yet

    def _keep_early(self, remote: RemoteParticipant, packet: bytes, source: Address) -> None:
        """Keep a packet of a writer that is not known yet, because its announcement comes to another port."""
        if self._early_size + len(packet) > bounds.EARLY_SIZE:
            self._wire.refuse('packet of an unknown writer', f'{self._early_size} bytes of such wait')
            return
        if len(remote.early) == bounds.EARLY_PACKETS:
            self._early_size -= len(remote.early.popleft()[0])
        if not remote.early:
            wire = self._wire
            wire.timers.at(wire.clock() + bounds.EARLY_S, partial(self._drop_early, remote))
        remote.early.append((packet, source))
        self._early_size += len(packet)

    def receive_early(self, remote: RemoteParticipant) -> None:
        """Read the kept packets of a participant, since one of its writers is known now."""
        for packet, source in self._take_early(remote):
            self.receive(packet, source)

    def _drop_early(self, remote: RemoteParticipant) -> None:
        self._take_early(remote)

    def _take_early(self, remote: RemoteParticipant) -> list[tuple[bytes, Address]]:
        """Remove the kept packets of a participant and return them."""
        early = list(remote.early)
        remote.early.clear()
        self._early_size -= sum(len(packet) for packet, _ in early)
        return early
