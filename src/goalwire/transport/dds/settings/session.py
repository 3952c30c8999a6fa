"""The settings of one session: first ROS 2's variables, then the file of the chosen RMW.

Source: rcl src/rcl/init.c and discovery_options.c; rmw_fastrtps_shared_cpp src/participant.cpp;
rmw_cyclonedds_cpp src/rmw_node.cpp. If both have a setting, the file wins.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from goalwire.errors import TransportError
from goalwire.fault_reports import LOGGER
from goalwire.host_addresses import find_interfaces
from goalwire.records import replace
from goalwire.rtps.io.addresses import STANDARD, Ports, Reach, data_port
from goalwire.rtps.io.settings import Settings
from goalwire.transport.dds.environment import Range, discovery_range, static_peers

if TYPE_CHECKING:
    from goalwire.transport.dds.settings.findings import Findings

FAST_DDS, CYCLONE, CONNEXT = 'rmw_fastrtps_cpp', 'rmw_cyclonedds_cpp', 'rmw_connextdds'

_REACH = {
    Range.SUBNET: Reach.SUBNET,
    Range.LOCALHOST: Reach.LOCALHOST,
    Range.OFF: Reach.OFF,
    Range.SYSTEM_DEFAULT: Reach.SUBNET,
}
_SERVER_VARIABLES = 'ROS_DISCOVERY_SERVER', 'ROS2_EASY_MODE'
_PROFILES = 'FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""The variables that name Fast DDS's profiles: first that of Fast DDS 3, then that of older versions."""
_NOT_READ = {
    FAST_DDS: (*_SERVER_VARIABLES, 'FASTDDS_ENVIRONMENT_FILE'),
    CYCLONE: (),
    CONNEXT: ('NDDS_QOS_PROFILES', 'NDDS_DISCOVERY_PEERS'),
}
"""Variables of each RMW that change its discovery, and have no effect here."""


def session_settings(domain: int, rmw: str = CYCLONE, *, lease_s: float = 20.0) -> Settings:
    """Return the settings of a session in a domain, as the RMW of this name would have them.

    `lease_s` applies if no file has a lease. One warning names all settings without effect here. Names of
    peers are looked up, for seconds at most; a peer without an address is left out with a warning. Raises
    TransportError for what cannot be understood.
    """
    range_ = discovery_range()
    settings = Settings(domain=domain, reach=_REACH[range_], lease_s=lease_s)
    findings = _read(domain, rmw)
    if findings is not None:
        settings = _apply(findings, settings)
    if range_ is Range.SYSTEM_DEFAULT:  # in this range only the file names peers
        settings = replace(settings, announces_here=not settings.multicast)
    peers = _find_peers(settings, findings, _static_peers(range_))
    _check(settings)
    _warn_of_interfaces(settings)
    _warn_of_ignored(findings, rmw)
    return replace(settings, peers=peers)


def asks_whom_the_standard_names(settings: Settings) -> bool:
    """Return whether participants at RTPS's standard ports on this machine are asked, and will answer."""
    return (
        settings.ports == STANDARD and settings.announces_here and not (settings.tag or settings.interfaces)
    )


def _read(domain: int, rmw: str) -> Findings | None:
    """Read the file of an RMW; None if it has none. The module that reads it is imported only then."""
    if rmw == CYCLONE and (uri := os.environ.get('CYCLONEDDS_URI', '').strip()):
        from goalwire.transport.dds.settings.cyclone import read_cyclone

        return read_cyclone(uri, domain)
    if rmw == FAST_DDS and (variable := next((name for name in _PROFILES if os.environ.get(name)), '')):
        from goalwire.transport.dds.settings.fast_dds import read_fast_dds

        return read_fast_dds(variable, os.environ[variable])
    return None


def _static_peers(range_: Range) -> list[str]:
    """Return ROS_STATIC_PEERS; empty unless the range is SUBNET or LOCALHOST, or with ROS_LOCALHOST_ONLY."""
    is_only_here = os.environ.get('ROS_LOCALHOST_ONLY', '').strip() == '1'
    return static_peers() if range_ in (Range.SUBNET, Range.LOCALHOST) and not is_only_here else []


def _apply(findings: Findings, settings: Settings) -> Settings:
    """Return `settings`, overridden by those of a file."""
    values = dict(findings.values)
    if values.get('multicast') is True and settings.reach is Reach.LOCALHOST:
        values['reach'] = Reach.SUBNET
    if findings.ports:
        values['ports'] = replace(Ports(), **findings.ports)
    return replace(
        settings,
        interfaces=tuple(dict.fromkeys(findings.interfaces)),
        excluded=tuple(dict.fromkeys(findings.excluded)),
        **values,
    )


def _check(settings: Settings) -> None:
    """Raise TransportError if the ports of a domain are not below 65536."""
    last = data_port(settings.domain, settings.participants - 1, settings.ports)
    if not 0 < last < 65536:
        raise TransportError(
            f'with these ports, participant {settings.participants - 1} of domain {settings.domain} would '
            f'have port {last}; set a smaller base, gain or number of participants'
        )


def _find_peers(settings: Settings, findings: Findings | None, static: list[str]) -> tuple[str, ...]:
    """Return the addresses of all named peers, those of a file first."""
    named = {} if findings is None else dict.fromkeys(findings.peers, findings.origin)
    for peer in static:
        named.setdefault(peer, 'ROS_STATIC_PEERS')
    if not named or settings.reach is Reach.OFF:
        return ()
    from goalwire.transport.dds.peers import Unusable, resolve

    found = resolve(named, settings.ipv6)
    peers: list[str] = []
    for peer, origin in named.items():
        known = found[peer]
        if isinstance(known, Unusable):
            _warn(f'{origin}: {peer[:80]!r} is left out: {known}. Name the machine by its address')
        else:
            peers += known
    return tuple(dict.fromkeys(peers))


def _warn_of_interfaces(settings: Settings) -> None:
    """Warn of named network interfaces that are missing: they are used as soon as they appear."""
    if not settings.interfaces:
        return
    there = find_interfaces(ipv6=settings.ipv6)
    known = {name for each in there for name in (each.name, each.address)}
    missing = [name for name in settings.interfaces if name not in known]
    if missing:
        listed = ', '.join(f'{each.name} ({each.address})' for each in there) or 'none'
        _warn(
            f'no interface has the name or address {", ".join(map(repr, missing))}; it is used when it '
            f'comes. There are: {listed}'
        )


def _warn_of_ignored(findings: Findings | None, rmw: str) -> None:
    """Log one warning that names all settings without effect here."""
    names = [name for name in _NOT_READ.get(rmw, ()) if os.environ.get(name)]
    if findings is not None and findings.ignored:
        names.append(f'in {findings.origin}: {", ".join(findings.ignored)}')
    if not names:
        return
    from goalwire.transport.dds.settings.findings import DISCOVERY_SERVER

    advice = ''
    if any(name in _SERVER_VARIABLES or DISCOVERY_SERVER in name for name in names):
        advice = (
            '. goalwire does not talk to discovery servers, and does not find programs that use one: start '
            'the robot without ROS_DISCOVERY_SERVER too, and if multicast does not pass, name the other '
            'machines in ROS_STATIC_PEERS'
        )
    _warn(f'set, but without effect on this session: {"; ".join(names)}{advice}')


def _warn(text: str) -> None:
    from goalwire.logging import get_logger  # imported here: needed only for a warning

    get_logger(LOGGER).warning(text)
