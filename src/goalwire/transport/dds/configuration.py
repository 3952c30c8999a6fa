"""A domain's configuration: what ROS 2's variables ask for, then CYCLONEDDS_URI, which has the last word.

Source of the rules: rmw_cyclonedds_cpp src/rmw_node.cpp (check_create_domain), rmw rmw_discovery_options.
Beyond ROS 2's: in the default range this machine is asked for participants directly too, so that two
programs find each other where multicast does not work; heartbeats follow a message after 10 ms instead of
100, so that a request that was faster than discovery is not late; datagrams have up to 64 KB, as Fast DDS
sends them: 1 MB messages pass at 1.9 GB/s in place of 0.7; and participants announce themselves every 5 s
instead of 30, for two that have lost each other when their network was down meet again no sooner.
"""

from __future__ import annotations

import os
from enum import Enum

from goalwire.errors import TransportError
from goalwire.transport.reports import LOGGER

MOST_PARTICIPANTS = 32
"""Participants of one domain on one machine that can be asked for directly (as in ROS 2)."""
_SIZES = '<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>60000B</FragmentSize>'
_LONGEST_QUOTED = 80
LARGEST_DOMAIN = 232
"""Beyond it a domain has no UDP ports."""


FAST_DDS_SERVICES = 'GOALWIRE_FASTDDS_SERVICES'
"""1: servers on Fast DDS may be called."""


class Range(Enum):
    """How far discovery looks (ROS_AUTOMATIC_DISCOVERY_RANGE)."""

    SUBNET = 'SUBNET'
    LOCALHOST = 'LOCALHOST'
    OFF = 'OFF'
    SYSTEM_DEFAULT = 'SYSTEM_DEFAULT'


def discovery_range() -> Range:
    """Return how far discovery looks; raises TransportError for an unknown word."""
    text = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', '').strip()
    if os.environ.get('ROS_LOCALHOST_ONLY', '').strip() == '1':
        return Range.LOCALHOST  # the older variable wins while it is set, as in ROS 2
    if not text:
        return Range.SUBNET
    try:
        return Range[text]
    except KeyError:
        raise TransportError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is '{text}'; choose one of: {', '.join(Range.__members__)}"
        ) from None


def static_peers() -> list[str]:
    """Return the addresses that ROS_STATIC_PEERS names, separated by semicolons."""
    return [peer for part in os.environ.get('ROS_STATIC_PEERS', '').split(';') if (peer := part.strip())]


def calls_fast_dds() -> bool:
    """Whether servers on Fast DDS may be called."""
    return os.environ.get(FAST_DDS_SERVICES, '').strip() == '1'


def domain_configuration(domain_id: int) -> str:
    """Return the whole configuration, as dds_create_domain takes it.

    Peers of ROS_STATIC_PEERS that have no address are left out with a warning. Raises TransportError, for
    one in CYCLONEDDS_URI too: the library would end the process. Names are looked up for seconds at most.
    """
    from goalwire.transport.dds import addresses  # socket is not needed by who only reads variables

    range_ = discovery_range()
    theirs = os.environ.get('CYCLONEDDS_URI', '').strip()
    configured, ipv6 = addresses.configured_peers(theirs, domain_id) if theirs else ([], False)
    ours = [] if range_ in {Range.SYSTEM_DEFAULT, Range.OFF} else static_peers()
    found = addresses.resolve(dict.fromkeys([*configured, *ours]), ipv6) if configured or ours else {}
    for peer in configured:
        if isinstance(error := found[peer], addresses.Unusable):
            raise TransportError(
                f'CYCLONEDDS_URI names the peer {_quoted(peer)}, and Cyclone DDS would end this process: '
                f'{error}. Correct the address, or take the peer out'
            )
    peers = [addresses.loopback(ipv6)]
    for peer in dict.fromkeys(ours):
        if isinstance(known := found[peer], addresses.Unusable):
            _warn(f'ROS_STATIC_PEERS: {_quoted(peer)} is left out: {known}. Name the machine by its address')
        else:
            peers += known
    own = _for_range(range_, list(dict.fromkeys(peers)))
    return ','.join(part for part in (own, theirs) if part)


def _warn(text: str) -> None:
    from goalwire.logging import get_logger  # needed only when something is broken

    get_logger(LOGGER).warning(text)


def _quoted(peer: str) -> str:
    return repr(peer if len(peer) <= _LONGEST_QUOTED else f'{peer[:_LONGEST_QUOTED]}…')


def _for_range(range_: Range, peers: list[str]) -> str:
    if range_ is Range.SYSTEM_DEFAULT:
        return ''
    if range_ is Range.OFF:
        general = '<AllowMulticast>false</AllowMulticast>'
        tag = f'ros_discovery_off_{os.getpid()}'
        discovery = f'<ParticipantIndex>none</ParticipantIndex><Tag>{tag}</Tag>'
    else:
        general = '<AllowMulticast>false</AllowMulticast>' if range_ is Range.LOCALHOST else ''
        discovery = (
            '<ParticipantIndex>auto</ParticipantIndex>'
            f'<MaxAutoParticipantIndex>{MOST_PARTICIPANTS}</MaxAutoParticipantIndex>'
            f'<Peers>{"".join(_peer(each) for each in peers)}</Peers>'
        )
    return (
        f'<CycloneDDS><Domain><General>{general}{_SIZES}</General>'
        f'<Discovery>{discovery}<SPDPInterval>5s</SPDPInterval></Discovery>'
        '<Internal><HeartbeatInterval>10ms</HeartbeatInterval></Internal></Domain></CycloneDDS>'
    )


def _peer(address: str) -> str:
    return f'<Peer address="{address}"/>'
