"""A participant without sockets: it hands received packets to its writers, readers and discovery."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count

from goalwire.records import replace
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import EndpointData, ParticipantData
from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.discovery import BUILTIN, Discovery, ParticipantListener, Settings
from goalwire.rtps.protocol.fragments import FRAGMENT_SIZES, PACKET_ROOM, FragmentSizes
from goalwire.rtps.protocol.matching import Matching
from goalwire.rtps.protocol.primitives import (
    INFINITE,
    MESSAGE_READER,
    MESSAGE_WRITER,
    NS,
    PREFIX_SIZE,
    PUBLICATIONS_READER,
    READER_KIND,
    WRITER_KIND,
    Address,
    PacketParts,
    RtpsError,
)
from goalwire.rtps.protocol.qos import (
    AUTOMATIC,
    MANUAL_BY_PARTICIPANT,
    RELIABLE,
    TRANSIENT_LOCAL,
    VOLATILE,
    Qos,
)
from goalwire.rtps.protocol.reader import Reader, ReaderListener
from goalwire.rtps.protocol.receiver import Receiver
from goalwire.rtps.protocol.wire import LOCAL, Watch, Wire
from goalwire.rtps.protocol.writer import Writer, WriterListener

_SEDP_QOS = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL)
_MESSAGE_QOS = Qos(reliability=RELIABLE, durability=VOLATILE)
_AUTOMATIC_MESSAGE, _MANUAL_MESSAGE = b'\0\0\0\1', b'\0\0\0\2'


class Participant(Wire):
    """An RTPS participant. Methods may be called on any thread; `receive` takes each received packet."""

    def __init__(
        self,
        settings: Settings,
        listener: ParticipantListener,
        *,
        clock: Callable[[], float],
        wall_clock_ns: Callable[[], int],
        send: Callable[[bytes, Address], None],
        send_parts: Callable[[PacketParts, Address], None] | None = None,
        on_sooner: Callable[[], None] = lambda: None,
        on_acknowledged: Callable[[], None] | None = None,
    ) -> None:
        """Make a participant; the functions among the arguments are passed to `Wire`."""
        super().__init__(
            settings.prefix,
            clock=clock,
            wall_clock_ns=wall_clock_ns,
            send=send,
            send_parts=send_parts,
            on_sooner=on_sooner,
            on_acknowledged=on_acknowledged,
        )
        self.data = ParticipantData(
            prefix=settings.prefix,
            metatraffic=settings.metatraffic,
            default=settings.default,
            lease=settings.lease,
            domain=settings.domain,
            tag=settings.tag,
            user_data=settings.user_data,
            name=settings.name,
            receive_buffer=settings.receive_buffer,
        )
        self._settings, self._listener = settings, listener
        sizes = _fragment_sizes(settings.packet_size)
        self._known = Matching(self, self.data, settings.own_hosts, sizes, is_ipv6=settings.ipv6)
        self._discovery = Discovery(self, settings, self.data, listener, self._known)
        self._receiver = Receiver(self, self._known, self._discovery)
        self._next_entity = count(1).__next__
        self._is_closed = False
        self._assertion: Watch | None = None
        for _, _, writer_id, reader_id in BUILTIN:
            qos = _MESSAGE_QOS if writer_id == MESSAGE_WRITER else _SEDP_QOS
            writer = EndpointData(self.prefix + writer_id, '', '', qos)
            self._known.add_writer(self._known.make_writer(writer, WriterListener(), is_keyed=True))
            reader = EndpointData(self.prefix + reader_id, '', '', qos)
            listens = _BuiltinListener(partial(self._take, reader_id))
            self._known.add_reader(self._known.make_reader(reader, listens))

    def start(self) -> None:
        """Announce the participant, now and periodically."""
        self.run(self._discovery.announce, None)

    def move(
        self,
        metatraffic: tuple[Address, ...],
        default: tuple[Address, ...],
        peers: tuple[Address, ...],
        own_hosts: frozenset[str],
    ) -> None:
        """Tell the other participants that this host's addresses have changed.

        `Settings` explains the arguments.
        """
        self.data = replace(self.data, metatraffic=metatraffic, default=default)
        self._settings = replace(
            self._settings, metatraffic=metatraffic, default=default, peers=peers, own_hosts=own_hosts
        )
        self.run(partial(self._discovery.move, self.data, self._settings), None)

    def close(self) -> None:
        """Tell the other participants that this one leaves, and stop."""
        self.run(self._close, None)

    def _close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = self._receiver.is_closed = True
        self._discovery.leave()
        for writer in self._known.writers.values():
            writer.stop()
        for reader in self._known.readers.values():
            reader.stop()
        if self._assertion is not None:
            self._assertion.stop()
        for table in (self._known.writers, self._known.readers, self._known.remotes, self._known.routes):
            table.clear()

    # ---- writers and readers

    def create_writer(
        self, topic: str, type_name: str, qos: Qos, listener: WriterListener, user_data: bytes = b''
    ) -> Writer:
        """Make a writer, and tell all participants of it.

        In a signal handler that interrupted `Wire.run` this returns at once; the announcement is sent after
        the handler.
        """
        data = EndpointData(self._new_guid(WRITER_KIND), topic, type_name, qos, user_data)
        writer = self._known.make_writer(data, listener)
        self.run(partial(self._open_writer, writer), None)
        return writer

    def create_reader(
        self, topic: str, type_name: str, qos: Qos, listener: ReaderListener, user_data: bytes = b''
    ) -> Reader:
        """Make a reader, and tell all participants of it.

        `create_writer` says how this acts in a signal handler.
        """
        data = EndpointData(self._new_guid(READER_KIND), topic, type_name, qos, user_data)
        reader = self._known.make_reader(data, listener)
        self.run(partial(self._open_reader, reader), None)
        return reader

    def announce_reader(self, topic: str, type_name: str, qos: Qos, user_data: bytes = b'') -> EndpointData:
        """Tell all participants of a reader that receives nothing, and return its announced data.

        Other participants then count the reader, and show its node; another local reader receives the topic's
        samples.
        """
        data = EndpointData(self._new_guid(READER_KIND), topic, type_name, qos, user_data)
        self.run(partial(self._tell, data), None)
        return data

    def withdraw_reader(self, guid: bytes) -> None:
        """Tell all participants that a reader from `announce_reader` has gone."""
        self.run(partial(self._tell_gone, guid), None)

    def delete(self, endpoint: Writer | Reader) -> None:
        """Remove a writer or a reader, and tell all participants that it has gone.

        A writer whose readers have not acknowledged all samples goes only then, or after `LINGER_S`: a reader
        ignores what a writer has sent before, once it knows that the writer has gone.
        """
        self.run(partial(self._delete, endpoint), None)

    def vendor_of(self, prefix: bytes) -> bytes:
        """Return the two bytes of a participant's vendor id; b'' if the participant is unknown."""
        remote = self._known.remotes.get(prefix)
        return b'' if remote is None else remote.data.vendor

    def is_acknowledged(self) -> bool:
        """Return True if all readers that have ever answered have acknowledged all their samples."""
        writers = [writer for writer in list(self._known.writers.values()) if writer.data.topic]
        return all(writer.is_acknowledged() for writer in writers)

    def ask_readers(self) -> None:
        """Ask all readers at once for acknowledgements, since a caller waits for them."""
        self.run(self._ask_readers, None)

    def _ask_readers(self) -> None:
        for writer in self._known.writers.values():
            writer.ask_now()

    def _new_guid(self, kind: int) -> bytes:
        return self.prefix + self._next_entity().to_bytes(3, 'big') + bytes((kind,))

    def _open_writer(self, writer: Writer) -> None:
        data = writer.data
        self._known.add_writer(writer)
        self._discovery.tell(data)
        if data.qos.liveliness == AUTOMATIC and data.qos.lease < INFINITE:
            self._assert_automatically()
        self._known.add_own(data)

    def _open_reader(self, reader: Reader) -> None:
        self._known.add_reader(reader)
        self._discovery.tell(reader.data)
        self._known.add_own(reader.data)

    def _tell(self, data: EndpointData) -> None:
        if not self._is_closed:
            self._discovery.tell(data)

    def _tell_gone(self, guid: bytes) -> None:
        if not self._is_closed:
            self._discovery.tell_gone(guid)

    def _delete(self, endpoint: Writer | Reader) -> None:
        if isinstance(endpoint, Writer):
            self._known.match_no_more(endpoint)
            endpoint.linger(partial(self._remove, endpoint))
        else:
            self._remove(endpoint)

    def _remove(self, endpoint: Writer | Reader) -> None:
        if self._known.remove(endpoint):
            self._discovery.tell_gone(endpoint.data.guid)

    # ---- packets

    def receive(self, packet: bytes | memoryview, source: Address) -> None:
        """Take a packet from an address. If a part of it breaks the rules, the rest is ignored.

        The memory of a memoryview may be used again afterwards.
        """
        self.run(partial(self._receiver.receive, packet, source), None)

    def receive_all(self, packets: Sequence[tuple[bytes | memoryview, Address]]) -> None:
        """Take some packets, each from an address, as `receive` does.

        Listeners are called after the last packet.
        """
        self.run(partial(self._receiver.receive_all, packets), None)

    def refuse(self, kind: str, reason: str) -> None:
        self.tell(self._listener.on_refused, kind, reason)

    def receive_own(self, packet: bytes) -> None:
        self._receiver.receive(packet, LOCAL)

    def _take(self, reader_id: bytes, sample: Sample) -> None:
        """Take a sample that a built-in reader has received."""
        self.run(partial(self._take_inside, reader_id, sample), None)

    def _take_inside(self, reader_id: bytes, sample: Sample) -> None:
        try:
            if reader_id == MESSAGE_READER:
                payload = bytes(sample.payload or b'')
                if len(payload) >= 20 and payload[4:16] == sample.writer[:PREFIX_SIZE]:
                    self._note_message(payload[4:16], payload[16:20])
                return
            remote = self._discovery.on_endpoint(sample, are_writers=reader_id == PUBLICATIONS_READER)
        except RtpsError as error:
            self.refuse('malformed announcement', str(error))
            return
        if remote is not None and remote.early:
            self._receiver.receive_early(remote)

    # ---- liveliness

    def _assert_automatically(self) -> None:
        """Periodically assert that the participant's writers are alive: twice within the shortest lease."""
        leases = [
            writer.data.qos.lease
            for writer in self._known.writers.values()
            if writer.data.qos.liveliness == AUTOMATIC
        ]
        if self._assertion is not None:
            self._assertion.stop()
        self._assertion = Watch(self, min(leases) / NS / 2, self._assert)

    def _assert(self) -> None:
        payload = b'\0\1\0\0' + self.prefix + _AUTOMATIC_MESSAGE + b'\1\0\0\0\0\0\0\0'
        self._known.writers[MESSAGE_WRITER].add(payload, key=self.prefix + _AUTOMATIC_MESSAGE)
        self._note_message(self.prefix, _AUTOMATIC_MESSAGE)

    def _note_message(self, prefix: bytes, kind: bytes) -> None:
        liveliness = {_AUTOMATIC_MESSAGE: AUTOMATIC, _MANUAL_MESSAGE: MANUAL_BY_PARTICIPANT}.get(kind)
        for guid, routes in self._known.routes.items():
            if guid[:PREFIX_SIZE] == prefix:
                for reader, proxy in routes:
                    if proxy.watch is not None and proxy.data.qos.liveliness == liveliness:
                        reader.note_alive(proxy)


def _fragment_sizes(packet_size: int | None) -> FragmentSizes:
    """Return the sizes of fragments for a packet size, both in bytes; each fragment has its own packet."""
    if packet_size is None:
        return FRAGMENT_SIZES
    return FragmentSizes(*[max(packet_size - PACKET_ROOM, bounds.LEAST_FRAGMENT)] * 3)


class _BuiltinListener(ReaderListener):
    """Passes the samples of a built-in reader on."""

    def __init__(self, take: Callable[[Sample], None]) -> None:
        self._take = take

    def on_sample(self, sample: Sample) -> None:
        self._take(sample)
