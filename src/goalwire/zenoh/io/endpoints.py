"""Addresses of sessions, as Zenoh writes them: tcp/localhost:7447, tls/[::1]:7447."""

from __future__ import annotations

import reprlib
import socket
from typing import Any, NamedTuple

from goalwire.errors import TransportError
from goalwire.records import record

LOOPBACK = '127.0.0.1'
"""localhost as a number, which works without a hosts file or DNS."""

PROTOCOLS = ('tcp', 'tls')
"""The link protocols that goalwire's own sessions speak."""


class Endpoint(NamedTuple):
    """An address to listen at, or to connect to."""

    protocol: str
    host: str
    port: int


@record
class TlsFiles:
    """Paths of PEM files, and checks of certificates: `transport/link/tls` of a Zenoh configuration."""

    root_ca_certificate: str = ''
    """The authorities that sign the certificates of others. If empty, the authorities that this system
    trusts."""
    listen_certificate: str = ''
    listen_private_key: str = ''
    connect_certificate: str = ''
    connect_private_key: str = ''
    enable_mtls: bool = False
    """True if sides that connect must show a certificate, too."""
    verify_name_on_connect: bool = True
    """True if the certificate must name the host that was dialled."""


def as_port(text: str) -> int | None:
    """Return the number of a TCP port, 0 included; None for any other text, however long."""
    is_number = text.isascii() and text.isdigit() and len(text) < 10
    return int(text) if is_number and int(text) < 65536 else None


def parse(text: str) -> Endpoint:
    """Read an address; metadata after '?' or '#' is ignored. Raises TransportError."""
    protocol, found, address = text.partition('/')
    host, colon, port = address.partition('#')[0].partition('?')[0].rpartition(':')
    number = as_port(port)
    if not (found and colon and host) or number is None:
        raise TransportError(f"'{text}' is not an address; write it as tcp/HOST:PORT")
    if protocol not in PROTOCOLS:
        raise TransportError(f"'{text}': {protocol} is not spoken here, but {', '.join(PROTOCOLS)}")
    return Endpoint(protocol, host.strip('[]'), number)


def _plain(host: str) -> str | bytes:
    """Return an ASCII name as bytes.

    Given a str, the socket functions would import the IDNA tables, which take 1 MB.
    """
    return host.encode() if host.isascii() and host.isprintable() else host


def is_quickly_resolved(host: str) -> bool:
    """True if a host's addresses are known without asking the network."""
    if host == 'localhost':
        return True
    try:
        _look_up(host, 0, socket.AI_NUMERICHOST)
    except OSError:
        return False
    return True


def _look_up(host: str, port: int, flags: int) -> list[tuple[socket.AddressFamily, Any]]:
    """Return families and socket addresses. Raises OSError, also for a malformed name."""
    try:
        found = socket.getaddrinfo(_plain(host), port, type=socket.SOCK_STREAM, flags=flags)
    except ValueError:  # the name has a NUL, or a label of more than 63 characters
        raise OSError(f'{reprlib.repr(host)} cannot be the name of a host') from None
    return [(family, address) for family, _, _, _, address in found]


def is_localhost_known() -> bool:
    """True if this machine resolves localhost; small containers have no hosts file that names it."""
    try:
        _look_up('localhost', 0, 0)
    except OSError:
        return False
    return True


def resolve(endpoint: Endpoint, *, passive: bool = False) -> list[tuple[socket.AddressFamily, Any]]:
    """Return families and socket addresses; raises OSError. Names that are not local may take seconds."""
    flags = socket.AI_PASSIVE if passive else 0
    if endpoint.host != 'localhost':
        return _look_up(endpoint.host, endpoint.port, flags)
    try:
        found = _look_up(endpoint.host, endpoint.port, flags)
    except OSError:  # without a hosts file, localhost still means this machine (RFC 6761)
        return _look_up(LOOPBACK, endpoint.port, flags)
    # 127.0.0.1 comes first: the rendezvous listens there, and ::1 would refuse each connection once.
    return sorted(found, key=lambda each: each[0] != socket.AF_INET)


def locators_of(listener: socket.socket, protocol: str = 'tcp') -> list[str]:
    """Return the addresses at which others reach a listening socket.

    For a socket that listens on all addresses, these are all addresses of this machine.
    """
    host, port = listener.getsockname()[:2]
    hosts = _own_addresses(listener.family) if host in {'0.0.0.0', '::'} else [host]  # noqa: S104
    return [f'{protocol}/{f"[{each}]" if ":" in each else each}:{port}' for each in hosts]


def _own_addresses(family: int) -> list[str]:
    """Return the addresses of this machine, those of its outgoing routes first."""
    found: dict[str, None] = {}
    for target in ('192.0.2.1', '10.255.255.255') if family == socket.AF_INET else ('2001:db8::1',):
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect((target, 9))  # connecting a UDP socket sends nothing
                found[probe.getsockname()[0]] = None
            except OSError:
                continue
    # A robot's network may have no route to other networks: then only the interfaces give its addresses.
    from goalwire.host_addresses import choose, find_interfaces

    own = choose(find_interfaces(ipv6=family == socket.AF_INET6))
    found |= dict.fromkeys(each.address for each in own if not each.is_of_link)
    if family == socket.AF_INET6:  # a listening socket for IPv6 usually accepts IPv4 as well
        found |= dict.fromkeys(_own_addresses(socket.AF_INET))
    return list(found) or (['127.0.0.1'] if family == socket.AF_INET else ['::1'])
