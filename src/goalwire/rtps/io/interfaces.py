"""The IPv4 addresses of this host."""

from __future__ import annotations

import socket
from contextlib import closing, suppress

LOOPBACK = '127.0.0.1'

_ADDRESS_OF_INTERFACE = 0x8915
"""SIOCGIFADDR of Linux."""
_ANY_OTHER = '192.0.2.1'
"""An address that nobody has: what would be sent there shows which address a packet leaves from."""


def addresses() -> tuple[str, ...]:
    """Return the addresses of this host but for loopback's, in the order of its interfaces."""
    found = dict.fromkeys(_of_interfaces())
    if not found:
        found = dict.fromkeys(_of_routes())
    return tuple(address for address in found if not address.startswith(('127.', '0.')))


def _of_interfaces() -> list[str]:
    """Ask the system for each interface's address; nothing where that is not known how."""
    try:
        import fcntl
    except ImportError:  # Windows
        return []
    found = []
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as sock:
        for _, name in socket.if_nameindex():
            with suppress(OSError):  # it has no address
                request = name.encode()[:15].ljust(32, b'\0')
                found.append(socket.inet_ntoa(fcntl.ioctl(sock, _ADDRESS_OF_INTERFACE, request)[20:24]))
    return found


def _of_routes() -> list[str]:
    """Ask which address a packet to elsewhere would have; nothing is sent."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as sock, suppress(OSError):
        sock.connect((_ANY_OTHER, 9))
        return [str(sock.getsockname()[0])]
    return []
