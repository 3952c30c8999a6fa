"""Finds the addresses of this host's network interfaces."""

from __future__ import annotations

import socket
from contextlib import closing, suppress
from typing import NamedTuple

LOOPBACK, LOOPBACK_V6 = '127.0.0.1', '::1'

_ADDRESS_OF_INTERFACE = 0x8915
"""Linux's SIOCGIFADDR: the ioctl that returns an interface's IPv4 address."""
_ANY_OTHER = {socket.AF_INET: '192.0.2.1', socket.AF_INET6: '2001:db8::1'}
"""Addresses that no host has. The local address of a socket connected to one shows which interface
is used.
"""
_TABLE_V6 = '/proc/net/if_inet6'


class Interface(NamedTuple):
    """One address of an interface."""

    name: str
    number: int
    """The system's number of the interface."""
    address: str
    """The address. A link-local address of IPv6 ends with the interface's name: fe80::1%eth0."""

    @property
    def is_loopback(self) -> bool:
        """True if nothing that is sent to this address leaves the host."""
        return self.address.startswith('127.') or self.address == LOOPBACK_V6

    @property
    def is_of_link(self) -> bool:
        """True if the address is valid only on one link (link-local)."""
        return '%' in self.address


def find_interfaces(*, ipv6: bool = False) -> tuple[Interface, ...]:
    """Return the addresses of this host, in the order of its interfaces."""
    found = _of_ipv6() if ipv6 else _of_ipv4()
    if not any(not each.is_loopback for each in found):
        found += _of_routes(socket.AF_INET6 if ipv6 else socket.AF_INET)
    return tuple(dict.fromkeys(found))


def choose(
    interfaces: tuple[Interface, ...], names: tuple[str, ...] = (), excluded: tuple[str, ...] = ()
) -> tuple[Interface, ...]:
    """Return the interfaces with one of these names or addresses; without `names`, all but loopback.

    Link-local addresses are left out if there are others, since a locator cannot contain the link. Interfaces
    in `excluded` are left out in any case.
    """
    if names:
        found = [each for name in names for each in interfaces if name in (each.name, each.address)]
    else:
        found = [each for each in interfaces if not each.is_loopback]
    found = [each for each in found if not {each.name, each.address} & {*excluded}]
    wide = [each for each in found if not each.is_of_link]
    return tuple(dict.fromkeys(wide or found))


def addresses() -> tuple[str, ...]:
    """Return the IPv4 addresses of this host except loopback's, in the order of its interfaces."""
    return tuple(each.address for each in choose(find_interfaces()))


def _of_ipv4() -> list[Interface]:
    """Ask the system for each interface's IPv4 address; return nothing on Windows, which has no
    such ioctl.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        return []
    found = []
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as sock:
        for index, name in socket.if_nameindex():
            with suppress(OSError):  # the interface has no address
                request = name.encode()[:15].ljust(32, b'\0')
                address = fcntl.ioctl(sock, _ADDRESS_OF_INTERFACE, request)[20:24]
                found.append(Interface(name, index, socket.inet_ntoa(address)))
    return found


def _of_ipv6() -> list[Interface]:
    """Read Linux's table of IPv6 addresses. Without it (on other systems) return only the
    loopback address.
    """
    from pathlib import Path  # imported here: it takes 1 ms, and few sessions use IPv6

    try:
        lines = Path(_TABLE_V6).read_text(encoding='ascii').splitlines()
    except OSError:
        return [Interface('lo', 0, LOOPBACK_V6)]
    found = []
    for line in lines:
        digits, index, _, scope, _, name = line.split()
        address = socket.inet_ntop(socket.AF_INET6, bytes.fromhex(digits))
        if int(scope, 16) & 0x20:
            address += f'%{name}'
        found.append(Interface(name, int(index, 16), address))
    return sorted(found, key=lambda each: each.number)


def _of_routes(family: int) -> list[Interface]:
    """Return the source address that a packet to another host would have; nothing is sent."""
    with closing(socket.socket(family, socket.SOCK_DGRAM)) as sock, suppress(OSError):
        sock.connect((_ANY_OTHER[socket.AddressFamily(family)], 9))
        address = str(sock.getsockname()[0])
        if address not in ('0.0.0.0', '::'):  # noqa: S104 - nothing is bound to it
            return [Interface('', 0, address)]
    return []
