"""ROS 2's variables about the network, as both DDS sessions read them, and the ports that are in use here.

Source of the rules: rmw rmw_discovery_options.
"""

from __future__ import annotations

import os
from contextlib import suppress
from enum import Enum

from goalwire.errors import TransportError

MOST_PARTICIPANTS = 32
"""How many participants of a domain on one machine are asked without multicast (as in ROS 2)."""
LARGEST_DOMAIN = 232
"""The largest domain id that has UDP ports."""


FILES = ('CYCLONEDDS_URI', 'FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""The variables that name the configuration files of RMWs."""


CHOICE = 'GOALWIRE_DDS'
NATIVE, CYCLONE = 'native', 'cyclone'
"""The variable that chooses the session: goalwire's own RTPS, or libddsc."""


def choose_session() -> str:
    """Return the chosen kind of session. Raises TransportError for an unknown word."""
    word = os.environ.get(CHOICE) or NATIVE
    if word not in {NATIVE, CYCLONE}:
        raise TransportError(f"{CHOICE} is '{word}'; set it to {NATIVE} or {CYCLONE}")
    return word


class Range(Enum):
    """The reach of discovery (ROS_AUTOMATIC_DISCOVERY_RANGE)."""

    SUBNET = 'SUBNET'
    LOCALHOST = 'LOCALHOST'
    OFF = 'OFF'
    SYSTEM_DEFAULT = 'SYSTEM_DEFAULT'


def discovery_range() -> Range:
    """Return how far discovery looks; raises TransportError for an unknown word."""
    text = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', '').strip()
    if os.environ.get('ROS_LOCALHOST_ONLY', '').strip() == '1':
        return Range.LOCALHOST  # this older variable wins while it is set, as in ROS 2
    if not text:
        return Range.SUBNET
    try:
        return Range[text]
    except KeyError:
        raise TransportError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is '{text}'; choose one of: {', '.join(Range.__members__)}"
        ) from None


_FIRST_PORT, _PORTS_OF_A_DOMAIN, _DISCOVERY_PORT = 7400, 250, 10
"""RTPS 2.5, 9.6.2.3: the first port of a domain, and the offsets of the discovery ports."""


def knows_its_peers() -> bool:
    """Return whether all possible peers listen at `ports_in_use`, since this process asks no other ports.

    False if an RMW's configuration file or ROS_STATIC_PEERS may name other peers.
    """
    if discovery_range() is not Range.LOCALHOST or any(os.environ.get(name, '').strip() for name in FILES):
        return False
    return not static_peers() and os.access(_SOCKETS[0], os.R_OK)


_SOCKETS = ('/proc/net/udp', '/proc/net/udp6')


def ports_in_use(domain_id: int) -> set[int]:
    """Return the ports of a domain at which other processes of this machine listen for discovery.

    Empty outside of the ranges SUBNET and LOCALHOST, in which these ports are asked, and on systems that do
    not list their sockets as Linux does.
    """
    if discovery_range() not in {Range.SUBNET, Range.LOCALHOST}:
        return set()
    first = _FIRST_PORT + _PORTS_OF_A_DOMAIN * domain_id + _DISCOVERY_PORT
    asked = range(first, first + 2 * MOST_PARTICIPANTS + 1, 2)
    found: dict[str, int] = {}
    for path in _SOCKETS:
        with suppress(OSError), open(path, encoding='ascii') as table:  # noqa: PTH123
            next(table, None)
            for line in table:
                columns = line.split()
                address, _, port = columns[1].rpartition(':')
                # A DDS library listens at all addresses; other programs may use such a port at one address.
                if int(port, 16) in asked and not address.strip('0'):
                    found[f'socket:[{columns[9]}]'] = int(port, 16)
    own = _own_sockets() if found else set()
    return {port for name, port in found.items() if name not in own}


def _own_sockets() -> set[str]:
    """Return the sockets of this process, as /proc names them."""
    own = set()
    with suppress(OSError):
        for descriptor in os.listdir('/proc/self/fd'):  # noqa: PTH208
            with suppress(OSError):  # the descriptor of `listdir` itself is closed by now
                own.add(os.readlink(f'/proc/self/fd/{descriptor}'))  # noqa: PTH115
    return own


def static_peers() -> list[str]:
    """Return the addresses that ROS_STATIC_PEERS names, separated by semicolons."""
    return [peer for part in os.environ.get('ROS_STATIC_PEERS', '').split(';') if (peer := part.strip())]
