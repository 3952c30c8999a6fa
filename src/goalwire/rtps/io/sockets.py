"""The UDP sockets of a participant: two of its own, and those that hear the multicast group."""

from __future__ import annotations

import errno
import socket
import struct
import sys
from collections.abc import Iterator
from contextlib import suppress

from goalwire.errors import TransportError
from goalwire.rtps.io.addresses import GROUP, MOST_PARTICIPANTS, Reach, data_port, discovery_port, first_port
from goalwire.rtps.io.interfaces import LOOPBACK
from goalwire.rtps.protocol.primitives import Address

BUFFER_SIZE = 4 << 20
"""Bytes that a socket is asked to hold; the system may give it less."""
_JOINED_ALONE = 49
"""IP_MULTICAST_ALL of Linux, which Python has no name for."""


class Sockets:
    """The sockets of one participant. `send` never blocks."""

    def __init__(self, domain: int, reach: Reach, hosts: tuple[str, ...]) -> None:
        """`hosts` are the addresses of this host. Raises TransportError if no ports are free."""
        self.receivers: list[socket.socket] = []
        """Those that packets come by."""
        self.lost = 0
        """Packets that could not be sent."""
        self._multicasters: list[socket.socket] = []
        self.metatraffic: tuple[Address, ...] = ()
        self.default: tuple[Address, ...] = ()
        """Where discovery, and where data reach the participant."""
        if reach is Reach.OFF:
            return
        try:
            discovery, data = self._open_unicast(domain)
            if reach is Reach.SUBNET:
                self._open_multicast(domain, hosts or (LOOPBACK,))
        except BaseException:
            self.close()
            raise
        announced = hosts or (LOOPBACK,)
        if reach is Reach.LOCALHOST:
            announced = announced[:1]
        self.metatraffic = tuple((host, discovery) for host in announced)
        self.default = tuple((host, data) for host in announced)
        self._sender = self.receivers[1]

    def _open_unicast(self, domain: int) -> tuple[int, int]:
        """Take the first pair of ports that is free, and return it."""
        for nth in range(MOST_PARTICIPANTS):
            ports = discovery_port(domain, nth), data_port(domain, nth)
            opened: list[socket.socket] = []
            try:
                for port in ports:
                    opened.append(_open())
                    opened[-1].bind(('', port))
            except OSError as error:
                for each in opened:
                    each.close()
                if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                    raise TransportError(f'no socket can be opened: {error.strerror}') from None
                continue
            self.receivers += opened
            return ports
        raise TransportError(
            f'domain {domain} has {MOST_PARTICIPANTS} participants on this host already; '
            f'end some of them, or use another ROS_DOMAIN_ID'
        )

    def _open_multicast(self, domain: int, hosts: tuple[str, ...]) -> None:
        """Join the group on each interface; one that cannot is left out."""
        for port in (first_port(domain), first_port(domain) + 1):
            sock = _open()
            self.receivers.append(sock)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if hasattr(socket, 'SO_REUSEPORT'):
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            if sys.platform == 'linux':
                sock.setsockopt(socket.IPPROTO_IP, _JOINED_ALONE, 0)
            sock.bind(('', port))
            for host in dict.fromkeys((*hosts, LOOPBACK)):
                joined = struct.pack('4s4s', socket.inet_aton(GROUP), socket.inet_aton(host))
                with suppress(OSError):
                    sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, joined)
        for host in hosts:
            sock = _open()
            self._multicasters.append(sock)
            with suppress(OSError):
                sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(host))

    def send(self, packet: bytes, address: Address) -> None:
        """Send a packet; one that the system does not take is lost, and counted."""
        if address[0] == GROUP:
            for sock in self._multicasters:
                with suppress(OSError):
                    sock.sendto(packet, address)
            return
        try:
            self._sender.sendto(packet, address)
        except OSError:
            self.lost += 1

    def drain(self, sock: socket.socket, most: int) -> Iterator[tuple[bytes, Address]]:
        """Yield the packets that have come by a socket, `most` of them."""
        for _ in range(most):
            try:
                yield sock.recvfrom(65536)
            except BlockingIOError:
                return
            except OSError:  # on some systems: nobody listened where something was sent
                continue

    def close(self) -> None:
        """Close all."""
        for sock in (*self.receivers, *self._multicasters):
            sock.close()


def _open() -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.setblocking(False)
    for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
        with suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, option, BUFFER_SIZE)
    return sock
