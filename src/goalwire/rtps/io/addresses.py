"""The ports of a participant, and the addresses to which it announces itself."""

from __future__ import annotations

import socket
from contextlib import suppress
from enum import Enum
from functools import cache

from goalwire.errors import TransportError
from goalwire.host_addresses import LOOPBACK, LOOPBACK_V6
from goalwire.records import record
from goalwire.rtps.protocol.primitives import Address

GROUP = '239.255.0.1'
"""The multicast group of discovery, by the standard."""
GROUPS_V6 = ('ff02::ffff:efff:1', 'ff1e::ffff:efff:1')
"""The groups on IPv6: the link-local one of Cyclone DDS, and the one of the standard and Fast DDS."""
MOST_DOMAIN = 232
"""The highest domain number: the ports of a higher domain would be above 65535."""
ANNOUNCED_PARTICIPANTS = 32
"""How many participants of a host get announcements by unicast: as many as with Fast DDS and Cyclone DDS."""
MOST_PARTICIPANTS = 120
"""How many participants of one host and domain can have ports."""


class Reach(Enum):
    """How far a participant looks for other participants."""

    OFF = 'off'
    LOCALHOST = 'localhost'
    SUBNET = 'subnet'


@record
class Ports:
    """The rule for the ports of a domain. All participants of a domain must use the same rule."""

    base: int = 7400
    domain_gain: int = 250
    participant_gain: int = 2
    multicast_discovery: int = 0
    discovery: int = 10
    multicast_data: int = 1
    data: int = 11


STANDARD = Ports()


def first_port(domain: int, ports: Ports = STANDARD) -> int:
    """Return the first port of a domain, from which its other ports are counted. Raises TransportError."""
    if not 0 <= domain <= MOST_DOMAIN:
        raise TransportError(f'there is no domain {domain} on DDS; the last one is {MOST_DOMAIN}')
    first = ports.base + ports.domain_gain * domain
    if not 0 < first < 65536:
        raise TransportError(f'domain {domain} would begin at port {first}; set a smaller base or gain')
    return first


def discovery_port(domain: int, participant: int, ports: Ports = STANDARD) -> int:
    """Return the discovery port of the nth participant of a host."""
    return first_port(domain, ports) + ports.discovery + ports.participant_gain * participant


def data_port(domain: int, participant: int, ports: Ports = STANDARD) -> int:
    """Return the data port of the nth participant of a host."""
    return first_port(domain, ports) + ports.data + ports.participant_gain * participant


def multicast_ports(domain: int, ports: Ports = STANDARD) -> tuple[int, int]:
    """Return the discovery port and the data port of the multicast group."""
    first = first_port(domain, ports)
    return first + ports.multicast_discovery, first + ports.multicast_data


def choose_announced_addresses(
    domain: int,
    hosts: tuple[str, ...],
    peers: tuple[str, ...] = (),
    groups: tuple[str, ...] = (),
    *,
    ports: Ports = STANDARD,
    participants: int = ANNOUNCED_PARTICIPANTS,
) -> tuple[Address, ...]:
    """Return the addresses to which a participant announces itself: `groups`, own `hosts`, and `peers`.

    A peer is HOST, whose first `participants` get announcements, or HOST:PORT, or [IPV6]:PORT.
    Raises TransportError for a peer whose name is not known.
    """
    found = [(group, multicast_ports(domain, ports)[0]) for group in groups]
    for host in (*hosts, *peers):
        name, port = split_port(host)
        address = look_up(name)
        if port is not None:
            found.append((address, port))
        else:
            found += [(address, discovery_port(domain, nth, ports)) for nth in range(participants)]
    return tuple(dict.fromkeys(found))


def split_port(peer: str) -> tuple[str, int | None]:
    """Return the host and the port of HOST, HOST:PORT, an IPv6 address, or [IPV6]:PORT."""
    if peer.startswith('['):
        host, _, port = peer[1:].partition(']')
        port = port.removeprefix(':')
    elif peer.count(':') == 1:
        host, _, port = peer.partition(':')
    else:
        return peer, None
    return host, int(port) if port.isdecimal() and 0 < int(port) < 65536 else None


@cache
def look_up(host: str) -> str:
    """Return the IPv4 address of a host name; return an IPv6 address in its normal form.

    Raises TransportError.
    """
    family = socket.AF_INET6 if ':' in host else socket.AF_INET
    with suppress(OSError, ValueError):  # for a numeric address Python need not load its codec for host names
        return socket.inet_ntop(family, socket.inet_pton(family, host))
    try:
        return str(socket.getaddrinfo(host, None, family, socket.SOCK_DGRAM)[0][4][0])
    except (OSError, UnicodeError) as error:
        raise TransportError(f"peer '{host}' is not known ({error}); give its address") from None


def choose_announced_hosts(hosts: tuple[str, ...], *, chosen: bool, ipv6: bool) -> tuple[str, ...]:
    """Return the addresses to which a participant sends announcements for others on this machine.

    Cyclone DDS ignores packets from the loopback address if it uses another interface, but other
    implementations may listen only on loopback: so both are used, unless interfaces are `chosen`.
    """
    loopback = LOOPBACK_V6 if ipv6 else LOOPBACK
    return hosts[:1] if chosen and hosts else (loopback, *hosts[:1])
