"""The local writers and readers, the remote ones, and which of them match."""

from __future__ import annotations

from collections import deque

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import EndpointData, ParticipantData
from goalwire.rtps.protocol.fragments import FragmentSizes
from goalwire.rtps.protocol.primitives import Address, is_ipv6, is_keyed, is_writer
from goalwire.rtps.protocol.qos import incompatible, share_partition
from goalwire.rtps.protocol.reader import Reader, ReaderListener, WriterProxy
from goalwire.rtps.protocol.wire import FOREVER, LOCAL, Watch, Wire
from goalwire.rtps.protocol.writer import Writer, WriterListener


class RemoteParticipant:
    """A record of another participant.

    This participant has a record of itself, too, because its own endpoints match each other.
    """

    __slots__ = (
        'address',
        'addresses',
        'answered_at',
        'data',
        'early',
        'endpoints',
        'hosts',
        'is_near',
        'is_proven',
        'is_reached',
        'reached_at',
        'sizes',
        'sources',
        'watch',
    )

    def __init__(self, data: ParticipantData, hosts: set[str], address: Address, is_near: bool) -> None:
        self.data = data
        self.hosts = hosts
        """The hosts from which its packets may come."""
        self.sources: set[Address] = set()
        """The addresses from which its packets came, as far as they were allowed."""
        self.address = address
        """The address of its discovery."""
        self.is_near = is_near
        """True if it is on this host."""
        self.is_proven = False
        """True once it has named this participant: so it reads packets at its address."""
        self.answered_at = -FOREVER
        """When this participant last answered it."""
        self.is_reached = False
        """True if its built-in endpoints are matched with this participant's."""
        self.reached_at = 0.0
        """When the built-in endpoints were matched."""
        self.endpoints: dict[bytes, EndpointData] = {}
        self.sizes: dict[bytes, int] = {}
        """The size of each endpoint's announcement, in bytes."""
        self.addresses: set[Address] = set()
        """The addresses to which its samples are sent."""
        self.early: deque[tuple[bytes, Address]] = deque()
        """Its packets from writers that are not known yet."""
        self.watch: Watch | None = None


class Matching:
    """Tables of all known endpoints, and of the readers that get each writer's samples.

    Methods are called inside `Wire.run`.
    """

    def __init__(
        self,
        wire: Wire,
        own: ParticipantData,
        own_hosts: frozenset[str],
        fragment_sizes: FragmentSizes,
        *,
        is_ipv6: bool = False,
    ) -> None:
        """Make empty tables. New writers use the sizes of fragments in `fragment_sizes`."""
        self.writers: dict[bytes, Writer] = {}
        self.readers: dict[bytes, Reader] = {}
        """The local endpoints, with the built-in ones, by entity id."""
        self.routes: dict[bytes, list[tuple[Reader, WriterProxy]]] = {}
        """The readers that get a writer's samples, by the writer's GUID."""
        self.own = RemoteParticipant(own, {LOCAL[0]}, LOCAL, is_near=True)
        """This participant, whose writers and readers match each other, too."""
        self.own.is_proven = self.own.is_reached = True
        self.remotes: dict[bytes, RemoteParticipant] = {own.prefix: self.own}
        """All participants by their prefix."""
        self.own_hosts = own_hosts
        self._endpoints_size = 0
        """The size of all other participants' endpoint announcements, in bytes."""
        self._wire = wire
        self._fragment_sizes = fragment_sizes
        self._is_ipv6 = is_ipv6

    # ---- the participant's own endpoints

    def make_writer(self, data: EndpointData, listener: WriterListener, *, is_keyed: bool = False) -> Writer:
        """Return a new writer, which matches no reader before `add_writer`. May be called on any thread."""
        return Writer(self._wire, data, listener, is_keyed=is_keyed, fragment_sizes=self._fragment_sizes)

    def add_writer(self, writer: Writer) -> None:
        """Add a writer from `make_writer` to the tables, so that it can match readers."""
        self.writers[writer.entity_id] = writer
        writer.start()

    def make_reader(self, data: EndpointData, listener: ReaderListener) -> Reader:
        """Return a new reader, which matches no writer before `add_reader`. May be called on any thread."""
        return Reader(self._wire, data, listener)

    def add_reader(self, reader: Reader) -> None:
        """Add a reader from `make_reader` to the tables, so that it can match writers."""
        self.readers[reader.entity_id] = reader
        reader.start()

    def add_own(self, own: EndpointData) -> None:
        """Match a local endpoint with all known endpoints."""
        self.own.endpoints[own.guid] = own
        for other in self._endpoints_of(own.topic, are_writers=not is_writer(own.entity_id)):
            self._compare_any(own, other)

    def remove(self, endpoint: Writer | Reader) -> bool:
        """Remove a local endpoint; return False if it was already removed."""
        if isinstance(endpoint, Writer):
            found = self.writers.pop(endpoint.entity_id, None)
        else:
            found = self.readers.pop(endpoint.entity_id, None)  # type: ignore[assignment]
        if found is None:
            return False
        if isinstance(endpoint, Reader):
            for writer in list(endpoint.writers):
                self.unroute(writer, endpoint.entity_id)
        self.match_no_more(endpoint)
        self._unmatch(endpoint.data)
        endpoint.stop()
        return True

    def match_no_more(self, endpoint: Writer | Reader) -> None:
        """Match a local endpoint with none of those that come from now on."""
        self.own.endpoints.pop(endpoint.data.guid, None)

    def _endpoints_of(self, topic: str, *, are_writers: bool) -> list[EndpointData]:
        return [
            endpoint
            for remote in self.remotes.values()
            for endpoint in remote.endpoints.values()
            if endpoint.topic == topic and is_writer(endpoint.entity_id) is are_writers
        ]

    # ---- others'

    def has_room(self, remote: RemoteParticipant, guid: bytes, size: int) -> bool:
        """Return True if there is room for an endpoint announced in `size` bytes; else count the refusal."""
        if guid not in remote.endpoints and len(remote.endpoints) >= bounds.MOST_ENDPOINTS:
            self._wire.refuse('endpoint', f'{bounds.MOST_ENDPOINTS} of one participant are known')
            return False
        if self._endpoints_size - remote.sizes.get(guid, 0) + size > bounds.ENDPOINTS_SIZE:
            self._wire.refuse('endpoint', f'{bounds.ENDPOINTS_SIZE} bytes are told of endpoints already')
            return False
        return True

    def take(self, remote: RemoteParticipant, endpoint: EndpointData, size: int = 0) -> bool:
        """Add or update another participant's writer or reader; return True if anything is new.

        The announcement of the endpoint had `size` bytes.
        """
        before = remote.endpoints.get(endpoint.guid)
        if before == endpoint:
            return False
        if before is not None:
            self._unmatch(before)
        remote.endpoints[endpoint.guid] = endpoint
        self._endpoints_size += size - remote.sizes.get(endpoint.guid, 0)
        remote.sizes[endpoint.guid] = size
        are_writers = is_writer(endpoint.entity_id)
        for own in list(self.own.endpoints.values()):
            if own.topic == endpoint.topic and is_writer(own.entity_id) is not are_writers:
                self._compare_any(own, endpoint)
        return True

    def lose(self, remote: RemoteParticipant, guid: bytes) -> EndpointData | None:
        """Forget a remote writer or reader, and return its data; None if it is not known."""
        endpoint = remote.endpoints.pop(guid, None)
        self._endpoints_size -= remote.sizes.pop(guid, 0)
        if endpoint is not None:
            self._unmatch(endpoint)
        return endpoint

    def _compare_any(self, own: EndpointData, other: EndpointData) -> None:
        if is_writer(own.entity_id):
            self._compare(own, other)
        else:
            self._compare(other, own)

    def _unmatch(self, endpoint: EndpointData) -> None:
        """Remove an endpoint from all endpoints with which it was matched."""
        if is_writer(endpoint.entity_id):
            for reader, _ in self.routes.pop(endpoint.guid, ()):
                reader.unmatch(endpoint.guid)
        else:
            for writer in list(self.writers.values()):
                writer.unmatch(endpoint.guid)

    def _compare(self, writer: EndpointData, reader: EndpointData) -> None:
        """Match a writer and a reader of one topic if they are compatible.

        At least one of the two is local.
        """
        own_writer = self.writers.get(writer.entity_id) if writer.prefix == self._wire.prefix else None
        own_reader = self.readers.get(reader.entity_id) if reader.prefix == self._wire.prefix else None
        are_keyed = {is_keyed(writer.entity_id), is_keyed(reader.entity_id)}
        is_alike = writer.type_name == reader.type_name and len(are_keyed) == 1
        if not is_alike or not share_partition(writer.qos.partition, reader.qos.partition):
            return
        policy = incompatible(writer.qos, reader.qos)
        if own_writer is not None:
            if policy is not None:
                self._wire.tell(own_writer.listener.on_incompatible, reader, policy)
            elif (remote := self.remotes.get(reader.prefix)) is not None:
                address = self._address_of(remote, reader)
                if address is not None:
                    own_writer.match(reader, address, is_near=remote.is_near, room=remote.data.receive_buffer)
        if own_reader is not None:
            if policy is not None:
                self._wire.tell(own_reader.listener.on_incompatible, writer, policy)
            elif (remote := self.remotes.get(writer.prefix)) is not None:
                address = self._address_of(remote, writer)
                if address is not None:
                    self.route(own_reader, writer, address)

    def _address_of(self, remote: RemoteParticipant, endpoint: EndpointData) -> Address | None:
        """Return the address to which packets for an endpoint are sent; None if no address is valid."""
        if remote is self.own:
            return LOCAL
        address = self.choose(endpoint.addresses or remote.data.default, remote.address[0])
        if address is None:
            self._wire.refuse('endpoint at an address of another host', remote.address[0])
        elif address not in remote.addresses:
            if len(remote.addresses) >= bounds.MOST_ADDRESSES:
                self._wire.refuse('address', f'{bounds.MOST_ADDRESSES} of one participant are known')
                return None
            remote.addresses.add(address)
        return address

    def route(self, reader: Reader, writer: EndpointData, address: Address) -> None:
        """Let a local reader get a writer's samples from now on."""
        self.unroute(writer.guid, reader.entity_id)
        self.routes.setdefault(writer.guid, []).append((reader, reader.match(writer, address)))

    def unroute(self, writer: bytes, reader_id: bytes) -> None:
        """Stop giving a writer's samples to a reader."""
        routes = self.routes.get(writer, [])
        for route in tuple(routes):
            reader = route[0]
            if reader.entity_id == reader_id:
                routes.remove(route)
                reader.unmatch(writer)
        if not routes:
            self.routes.pop(writer, None)

    # ---- the addresses of endpoints

    def choose(self, addresses: tuple[Address, ...], host: str) -> Address | None:
        """Return a participant's address on `host`, which its packets come from; None if it announces none.

        For a participant on this machine, any address of this machine is accepted. An address on another host
        is refused, since packets could hit a program that has never asked for them.
        """
        on_link = host.partition('%')[0]
        for address in addresses:
            if address[0] == on_link:
                return host, address[1]
        if host in self.own_hosts:
            for address in addresses:
                if address[0] in self.own_hosts:
                    return address
        return None

    def first(self, addresses: tuple[Address, ...]) -> Address | None:
        """Return the first address that this participant's sockets can send to."""
        return next((each for each in addresses if is_ipv6(each[0]) is self._is_ipv6), None)

    def move(self, own: ParticipantData, own_hosts: frozenset[str]) -> None:
        """Note that the addresses of this host, and of its participants, have changed."""
        self.own.data, self.own_hosts = own, own_hosts
        for remote in self.remotes.values():
            if remote.is_near and remote is not self.own:
                remote.hosts |= own_hosts
                remote.sources.clear()

    def follow(self, remote: RemoteParticipant) -> None:
        """Send to a participant's endpoints at its present addresses."""
        prefix = remote.data.prefix
        for writer in self.writers.values():
            for guid, reader in writer.readers.items():
                if guid.startswith(prefix):
                    writer.move(guid, self._place_of(remote, reader.data) or reader.address)
        for guid, routes in self.routes.items():
            if guid.startswith(prefix):
                for _, proxy in routes:
                    proxy.address = self._place_of(remote, proxy.data) or proxy.address

    def _place_of(self, remote: RemoteParticipant, endpoint: EndpointData) -> Address | None:
        """Return the address of an endpoint.

        Built-in endpoints, without a topic, are at the discovery address.
        """
        return self._address_of(remote, endpoint) if endpoint.topic else remote.address
