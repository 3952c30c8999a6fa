"""Which ports a participant has, and where it announces itself."""

from __future__ import annotations

import socket
from enum import Enum
from functools import cache

from goalwire.errors import TransportError
from goalwire.rtps.io.interfaces import LOOPBACK
from goalwire.rtps.protocol.primitives import Address

GROUP = '239.255.0.1'
"""The multicast group of discovery, by the standard."""
MOST_DOMAIN = 232
"""The last domain whose ports exist."""
ANNOUNCED_PARTICIPANTS = 32
"""Participants of one host that are announced to: as many as Fast DDS and Cyclone DDS try."""
MOST_PARTICIPANTS = 120
"""Participants of one host and domain that have ports."""


class Reach(Enum):
    """How far a participant looks for others."""

    OFF = 'off'
    LOCALHOST = 'localhost'
    SUBNET = 'subnet'


def first_port(domain: int) -> int:
    """Return the port of discovery by multicast; those of the domain follow. Raises TransportError."""
    if not 0 <= domain <= MOST_DOMAIN:
        raise TransportError(f'there is no domain {domain} on DDS; the last one is {MOST_DOMAIN}')
    return 7400 + 250 * domain


def discovery_port(domain: int, participant: int) -> int:
    """Return the port of discovery of the nth participant of a host."""
    return first_port(domain) + 10 + 2 * participant


def data_port(domain: int, participant: int) -> int:
    """Return the port of data of the nth participant of a host."""
    return first_port(domain) + 11 + 2 * participant


def announced_addresses(
    domain: int, reach: Reach, hosts: tuple[str, ...], peers: tuple[str, ...] = ()
) -> tuple[Address, ...]:
    """Return where a participant announces itself: to the group, to this host, and to `peers`.

    `hosts` are the addresses of this host. Cyclone DDS ignores what comes from loopback's address if it uses
    another interface, and other implementations may listen only on loopback: so both are announced to.

    Raises TransportError for a peer whose name is not known.
    """
    if reach is Reach.OFF:
        return ()
    found: list[Address] = []
    if reach is Reach.SUBNET:
        found.append((GROUP, first_port(domain)))
    for host in (LOOPBACK, *hosts[:1], *peers):
        address = look_up(host)
        found += [(address, discovery_port(domain, nth)) for nth in range(ANNOUNCED_PARTICIPANTS)]
    return tuple(dict.fromkeys(found))


@cache
def look_up(host: str) -> str:
    """Return the IPv4 address of a host; raises TransportError."""
    try:
        return str(socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_DGRAM)[0][4][0])
    except (OSError, UnicodeError) as error:
        raise TransportError(f"peer '{host}' is not known ({error}); give its IPv4 address") from None
