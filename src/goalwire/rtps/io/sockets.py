"""The UDP sockets of a participant: two for unicast, and those that have joined the multicast groups."""

from __future__ import annotations

import errno
import socket
import struct
import sys
from contextlib import suppress

from goalwire.concurrency.forks import open_privately
from goalwire.errors import TransportError
from goalwire.freed_memory import keep_freed_memory
from goalwire.host_addresses import LOOPBACK, LOOPBACK_V6, Interface
from goalwire.rtps.io.addresses import (
    MOST_PARTICIPANTS,
    Reach,
    data_port,
    discovery_port,
    multicast_ports,
)
from goalwire.rtps.io.settings import Settings
from goalwire.rtps.protocol.primitives import LARGE, Address, PacketParts

_ALL_GROUPS, _ALL_GROUPS_V6 = (socket.IPPROTO_IP, 49), (socket.IPPROTO_IPV6, 29)
"""Linux's IP_MULTICAST_ALL and IPV6_MULTICAST_ALL, for which Python has no names."""
_SENDS_BY = socket.IPPROTO_IP, socket.IP_MULTICAST_IF
_SENDS_BY_V6 = socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF
_SENDS_PARTS = hasattr(socket.socket, 'sendmsg')
_OUT_OF_PORTS = errno.EADDRINUSE, errno.EACCES

LARGE_AT_ONCE = 8
"""How many packets are read at once while large packets come: each has a buffer that is used again."""
MOST_BYTES = 1 << 16
"""The largest UDP packet."""
TURNS_BETWEEN_LOOKS = 8


class Sockets:
    """The sockets of one participant. `send` never blocks."""

    def __init__(self, settings: Settings, interfaces: tuple[Interface, ...]) -> None:
        """Open the sockets on `interfaces`. Raises TransportError if no ports are free."""
        self._settings = settings
        self._family = socket.AF_INET6 if settings.ipv6 else socket.AF_INET
        self._groups = frozenset(settings.groups)
        self.receivers: list[socket.socket] = []
        """The sockets that receive packets."""
        self.lost = 0
        """Packets that could not be sent."""
        self._until_look = 0
        """How many calls of `read` pass before it tries to read a second packet again."""
        self._expects_large = False
        """True after a large packet of samples."""
        self._memory: list[memoryview] = []
        """Buffers for large packets, which are made for the first large packet and then used again."""
        self._listeners: list[socket.socket] = []
        """The receivers that have joined the groups."""
        self._interfaces: dict[Interface, bytes] = {}
        """The interfaces by which packets go to the groups, each with the socket option's value that selects
        it.
        """
        self._ports = 0, 0
        self.metatraffic: tuple[Address, ...] = ()
        self.default: tuple[Address, ...] = ()
        """The addresses at which the participant receives discovery, and data."""
        if settings.reach is Reach.OFF:
            return
        try:
            self._ports = self._open_unicast()
            self.discovery, self._sender = self.receivers
            if self._groups:
                self._listeners = [
                    self._open_listener(port) for port in multicast_ports(settings.domain, settings.ports)
                ]
                self._join(self._loopback())
            self.use(interfaces)
        except BaseException:
            self.close()
            raise

    def _loopback(self) -> Interface:
        """Return the loopback interface, on which multicast stays within this machine."""
        if not self._settings.ipv6:
            return Interface('lo', 0, LOOPBACK)
        index = next((index for index, name in socket.if_nameindex() if name.startswith('lo')), 0)
        return Interface('lo', index, LOOPBACK_V6)

    def use(self, interfaces: tuple[Interface, ...]) -> None:
        """Use these interfaces from now on.

        Call this again when interfaces or their addresses have changed.
        """
        settings = self._settings
        if settings.reach is Reach.OFF:
            return
        used = interfaces or (self._loopback(),)
        if self._groups:
            for new in used:
                if new not in self._interfaces:
                    self._join(new)
            self._interfaces = {each: self._name(each) for each in used}
        if settings.reach is Reach.LOCALHOST:
            used = used[:1]
        discovery, data = self._ports
        hosts = [each.address.partition('%')[0] for each in used]
        self.metatraffic = tuple((host, discovery) for host in hosts)
        self.default = tuple((host, data) for host in hosts)

    def _open_unicast(self) -> tuple[int, int]:
        """Bind and return the pair of ports of the configured participant index, or the first free pair."""
        settings = self._settings
        domain, chosen = settings.domain, settings.participant
        tried = range(MOST_PARTICIPANTS) if chosen is None else (chosen,)
        for nth in tried:
            ports = discovery_port(domain, nth, settings.ports), data_port(domain, nth, settings.ports)
            opened: list[socket.socket] = []
            try:
                for port in ports:
                    opened.append(self._open())
                    opened[-1].bind(('', port))
            except (OSError, OverflowError) as error:
                for each in opened:
                    each.close()
                if isinstance(error, OSError) and error.errno not in _OUT_OF_PORTS:
                    raise TransportError(f'no socket can be opened: {error.strerror}') from None
                continue
            self.receivers += opened
            return ports
        if chosen is not None:
            raise TransportError(
                f'the ports of participant {chosen} in domain {domain} are taken: '
                f'end the program that has them, or leave the choice of the participant index open'
            )
        raise TransportError(
            f'domain {domain} has {MOST_PARTICIPANTS} participants on this host already; '
            f'end some of them, or use another ROS_DOMAIN_ID'
        )

    def _open_listener(self, port: int) -> socket.socket:
        sock = self._open()
        self.receivers.append(sock)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, 'SO_REUSEPORT'):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        # On Linux a socket receives from all groups that any program has joined, unless this option is 0.
        if sys.platform == 'linux':
            level, option = _ALL_GROUPS_V6 if self._settings.ipv6 else _ALL_GROUPS
            with suppress(OSError):
                sock.setsockopt(level, option, 0)
        sock.bind(('', port))
        return sock

    def _join(self, interface: Interface) -> None:
        """Join the multicast groups on an interface; skip a group that cannot be joined."""
        for sock in self._listeners:
            for group in self._groups:
                joined = socket.inet_pton(self._family, group)
                with suppress(OSError):
                    if self._settings.ipv6:
                        request = joined + struct.pack('@I', interface.number)
                        sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, request)
                    else:
                        request = joined + socket.inet_aton(interface.address)
                        sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)

    def _name(self, interface: Interface) -> bytes:
        """Return the value of the socket option that selects an interface for sending multicast packets."""
        if self._settings.ipv6:
            return struct.pack('@I', interface.number)
        return socket.inet_aton(interface.address)

    @property
    def port(self) -> int:
        """The source port of all packets; 0 if there are no sockets."""
        return self._ports[1]

    @property
    def receive_buffer(self) -> int:
        """How many bytes of unread packets the system keeps for the data socket; 0 if there is none."""
        return self._sender.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) if self.receivers else 0

    def send(self, packet: bytes, address: Address) -> None:
        """Send a packet; a packet that the system does not accept is lost, and counted."""
        if address[0] in self._groups:
            self._send_to_group(packet, address)
            return
        try:
            self._sender.sendto(packet, address)
        except OSError:
            self.lost += 1

    def send_parts(self, parts: PacketParts, address: Address) -> None:
        """Send a packet that is given in parts, as `send` does; the parts are not joined in Python."""
        keep_freed_memory()
        if address[0] in self._groups or not _SENDS_PARTS:
            self.send(b''.join(parts), address)
            return
        try:
            self._sender.sendmsg(parts, (), 0, address)
        except OSError:
            self.lost += 1

    def _send_to_group(self, packet: bytes, group: Address) -> None:
        """Send a packet to a multicast group by each interface, from the same source port as all packets."""
        option = _SENDS_BY_V6 if self._settings.ipv6 else _SENDS_BY
        for name in self._interfaces.values():
            with suppress(OSError):
                self._sender.setsockopt(*option, name)
                self._sender.sendto(packet, group)

    def read(self, sock: socket.socket, most: int) -> list[tuple[bytes | memoryview, Address]]:
        """Return at most `most` packets that a socket has received, each with its sender.

        A packet that is a memoryview is valid until the next `read`.

        A read that finds no packet costs 2 us, and a whole service call takes 50 us. So more than one data
        packet is read only while data packets come in bursts, and now and then to detect a burst. Discovery
        packets are always read completely, so that news of a writer or reader is seldom later than the
        samples that follow it.
        """
        packets: list[tuple[bytes | memoryview, Address]] = []
        has_samples = sock is self._sender
        if has_samples and self._expects_large:
            return self._read_large(sock)
        if has_samples and self._until_look:
            self._until_look -= 1
            most = 1
        for _ in range(most):
            try:
                packet, source = sock.recvfrom(MOST_BYTES)
            except BlockingIOError:
                break
            except OSError:  # on some systems an ICMP error of an earlier send is raised here
                continue
            packets.append((packet, source[:2]))
            if len(packet) > LARGE and has_samples:
                self._until_look = 0
                return packets + self._read_large(sock)
        if has_samples and most > 1:
            self._until_look = 0 if len(packets) > 1 else TURNS_BETWEEN_LOOKS
        return packets

    def _read_large(self, sock: socket.socket) -> list[tuple[bytes | memoryview, Address]]:
        """Read some packets, and keep the large ones in buffers that are used again.

        Allocating 64 KiB for each packet would take longer than copying the packet into them.
        """
        packets: list[tuple[bytes | memoryview, Address]] = []
        if not self._memory:
            keep_freed_memory()
            self._memory = [memoryview(bytearray(MOST_BYTES)) for _ in range(LARGE_AT_ONCE)]
        self._expects_large = False
        for memory in self._memory:
            try:
                size, source = sock.recvfrom_into(memory)
            except BlockingIOError:
                break
            except OSError:  # as in `read`
                continue
            if size > LARGE:
                self._expects_large = True
                packets.append((memory[:size], source[:2]))
            else:
                packets.append((bytes(memory[:size]), source[:2]))
        return packets

    def close(self) -> None:
        """Close all."""
        for sock in self.receivers:
            sock.close()

    def _open(self) -> socket.socket:
        sock = open_privately(lambda: socket.socket(self._family, socket.SOCK_DGRAM))
        sock.setblocking(False)
        settings = self._settings
        if settings.ipv6:
            with suppress(OSError):
                sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        for option, size in (
            (socket.SO_RCVBUF, settings.receive_buffer),
            (socket.SO_SNDBUF, settings.send_buffer),
        ):
            with suppress(OSError):
                sock.setsockopt(socket.SOL_SOCKET, option, size)
        return sock
