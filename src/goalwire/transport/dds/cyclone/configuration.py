"""A domain's configuration: ROS 2's variables first, then CYCLONEDDS_URI, which overrides them.

Source of the rules: rmw_cyclonedds_cpp src/rmw_node.cpp (check_create_domain), rmw rmw_discovery_options.
Four settings differ from ROS 2's:

- In the default range participants on this machine are also asked directly, so that two programs find each
  other where multicast does not work.
- Heartbeats follow a message after 10 ms instead of 100, so that a request that was sent before its server
  was discovered is soon sent again.
- Datagrams have up to 64 KB, as Fast DDS sends them: 1 MB messages pass at 1.9 GB/s instead of 0.7.
- Participants announce themselves every 5 s instead of 30. Two that lost each other while their network was
  down meet again with the next announcement.

Addresses of peers are checked before libddsc sees them. It looks peers up while it makes a domain, and ends
the process if it cannot use one: abort() for a name that does not resolve, a crash for 0.0.0.0. So the
names of ROS_STATIC_PEERS are looked up here, within bounded time, and the library gets numbers. The peers in
CYCLONEDDS_URI are looked up too, so that an error can name them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from goalwire.errors import TransportError
from goalwire.fault_reports import LOGGER
from goalwire.transport.dds.environment import MOST_PARTICIPANTS, Range, discovery_range, static_peers
from goalwire.transport.dds.peers import Unusable, resolve

_SIZES = '<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>60000B</FragmentSize>'
_LONGEST_QUOTED = 80


def domain_configuration(domain_id: int) -> str:
    """Return the whole configuration as text for dds_create_domain.

    Peers of ROS_STATIC_PEERS that have no address are left out with a warning. A peer in CYCLONEDDS_URI
    without an address raises TransportError, since the library would end the process. Names are looked up for
    seconds at most.
    """
    range_ = discovery_range()
    theirs = os.environ.get('CYCLONEDDS_URI', '').strip()
    configured, ipv6 = configured_peers(theirs, domain_id) if theirs else ([], False)
    ours = [] if range_ in {Range.SYSTEM_DEFAULT, Range.OFF} else static_peers()
    found = resolve(dict.fromkeys([*configured, *ours]), ipv6) if configured or ours else {}
    for peer in configured:
        if isinstance(error := found[peer], Unusable):
            raise TransportError(
                f'CYCLONEDDS_URI names the peer {_quote(peer)}, and Cyclone DDS would end this process: '
                f'{error}. Correct the address, or take the peer out'
            )
    peers = [loopback(ipv6)]
    for peer in dict.fromkeys(ours):
        if isinstance(known := found[peer], Unusable):
            _warn(f'ROS_STATIC_PEERS: {_quote(peer)} is left out: {known}. Name the machine by its address')
        else:
            peers += known
    own = _for_range(range_, list(dict.fromkeys(peers)))
    return ','.join(part for part in (own, theirs) if part)


def _warn(text: str) -> None:
    from goalwire.logging import get_logger  # imported here: needed only for a warning

    get_logger(LOGGER).warning(text)


def _quote(peer: str) -> str:
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


_COMMENT = re.compile('<!--.*?-->', re.DOTALL)
_TAG = re.compile(r'<(/?)(\w+)((?:[^<>"\']|"[^"]*"|\'[^\']*\')*)>([^<]*)')
_ATTRIBUTE = re.compile(r'(\w+)\s*=\s*(?:"([^"]*)"|\'([^\']*)\')')
_VARIABLE = re.compile(r'\$\{(\w+)(?::-([^}]*))?\}')


def loopback(ipv6: bool) -> str:
    """Return the loopback address."""
    return '[::1]' if ipv6 else '127.0.0.1'


def configured_peers(uri: str, domain_id: int) -> tuple[list[str], bool]:
    """Return the peers that a CYCLONEDDS_URI names for a domain, and whether it asks for IPv6.

    Text that cannot be read here is ignored: the library itself reports it, and does not abort.
    """
    peers: list[str] = []
    ipv6 = False
    for text in _texts(uri):
        applies = True
        for closing, element, attributes, content in _TAG.findall(_COMMENT.sub('', text)):
            name = element.lower()
            given = {key.lower(): one or other for key, one, other in _ATTRIBUTE.findall(attributes)}
            if name == 'domain':
                applies = bool(closing) or given.get('id', 'any').lower() in {'any', '', str(domain_id)}
            elif applies and name == 'peer':
                peers += [part for part in _expand(given.get('address', '')).split(',') if part]
            elif applies and name in {'transport', 'useipv6'} and not closing:
                ipv6 = _expand(content).strip().lower() in {'udp6', 'tcp6', 'true'}
    return peers, ipv6


def _texts(uri: str) -> Iterator[str]:
    """Yield the pieces of XML that a CYCLONEDDS_URI holds or names."""
    if '<' in uri:
        yield uri
    for part in uri.split(','):
        path = part.strip().removeprefix('file://')
        if path and '<' not in path and '>' not in path and os.path.isfile(path):  # noqa: PTH113
            try:
                with open(path, encoding='utf-8', errors='replace') as file:  # noqa: PTH123
                    yield file.read(1_000_000)
            except OSError:
                continue  # the library itself reports a file that cannot be read


def _expand(text: str) -> str:
    """Expand ${NAME} and ${NAME:-otherwise}, as the library does, and XML's character entities."""
    for sign, name in (('<', 'lt'), ('>', 'gt'), ('"', 'quot'), ("'", 'apos'), ('&', 'amp')):
        text = text.replace(f'&{name};', sign)
    return _VARIABLE.sub(lambda match: os.environ.get(match[1]) or match[2] or '', text)
