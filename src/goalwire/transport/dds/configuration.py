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

MOST_PARTICIPANTS = 32
"""Participants of one domain on one machine that can be asked for directly (as in ROS 2)."""
_SIZES = '<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>60000B</FragmentSize>'
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


def domain_configuration() -> str:
    """Return the whole configuration, as dds_create_domain takes it. Raises TransportError."""
    own = _for_range(discovery_range(), static_peers())
    theirs = os.environ.get('CYCLONEDDS_URI', '').strip()
    return ','.join(part for part in (own, theirs) if part)


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
            f'<Peers>{"".join(_peer(each) for each in ("localhost", *peers))}</Peers>'
        )
    return (
        f'<CycloneDDS><Domain><General>{general}{_SIZES}</General>'
        f'<Discovery>{discovery}<SPDPInterval>5s</SPDPInterval></Discovery>'
        '<Internal><HeartbeatInterval>10ms</HeartbeatInterval></Internal></Domain></CycloneDDS>'
    )


def _peer(address: str) -> str:
    # xml.sax.saxutils would do this too, and import all of urllib
    for sign, name in (('&', 'amp'), ('<', 'lt'), ('"', 'quot')):
        address = address.replace(sign, f'&{name};')
    return f'<Peer address="{address}"/>'
