"""Reads from Fast DDS's XML profiles how participants find and reach each other.

Source: Fast DDS' documentation, "XML profiles"; rmw_fastrtps_shared_cpp src/participant.cpp. rmw_fastrtps
takes the participant profile with is_default_profile="true"; profiles of topics, publishers and
subscriptions hold only with RMW_FASTRTPS_USE_QOS_FROM_XML=1, and have no effect here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from goalwire.rtps.io.addresses import MOST_PARTICIPANTS, Reach
from goalwire.transport.dds.settings.findings import DISCOVERY_SERVER, Findings, local_name, within
from goalwire.xml_tree import Element

_LONGEST_S = 10 * 365 * 86400.0
_DATAGRAM = 65_507


def read_fast_dds(variable: str, location: str) -> Findings:
    """Read the profiles in the file that an environment variable names. Raises TransportError."""
    findings = Findings(variable)
    root = findings.parse(findings.read_file(location.removeprefix('file://')))
    profiles = root if local_name(root) == 'profiles' else within(root, 'profiles') or root
    for profile in _default_profiles(profiles, findings):
        transports = _read_participant(profile, findings)
        _read_transports(profiles, transports, findings)
    return findings


def _default_profiles(profiles: Element, findings: Findings) -> Iterator[Element]:
    """Yield the participant profile that applies."""
    for child in profiles.children:
        match local_name(child):
            case 'participant' if child.attributes.get('is_default_profile', '').lower() == 'true':
                yield child
            case 'participant':
                findings.ignore(f'participant {child.attributes.get("profile_name", "")!r}, not the default')
            case 'transport_descriptors':
                pass
            case _:
                findings.ignore(child.tag)


def _leaves(element: Element, parents: tuple[str, ...] = ()) -> Iterator[tuple[str, Element]]:
    """Yield each element that has a reader or no children, with its path below the profile."""
    path = (*parents, element.tag)
    name = '/'.join(path).lower()
    if name in _READERS or not element.children:
        yield name, element
        return
    for child in element.children:
        yield from _leaves(child, path)


def _read_participant(profile: Element, findings: Findings) -> list[str]:
    """Read a participant profile, and return the ids of the transports that it uses."""
    transports: list[str] = []
    for child in profile.children:
        if local_name(child) != 'rtps':
            findings.ignore(child.tag)
            continue
        for each in child.children:
            for name, element in _leaves(each):
                if name == 'usertransports/transport_id':
                    transports.append(element.text.strip())
                elif (read := _READERS.get(name)) is not None:
                    read(findings, element)
                elif name not in _WITHOUT_MEANING:
                    findings.ignore(name)
    return transports


def _read_transports(profiles: Element, wanted: list[str], findings: Findings) -> None:
    descriptors = within(profiles, 'transport_descriptors')
    kinds = set()
    for descriptor in [] if descriptors is None else descriptors.children:
        found = within(descriptor, 'transport_id')
        if found is None or found.text.strip() not in wanted:
            continue
        kind = within(descriptor, 'type')
        kinds.add(kind.text.strip() if kind is not None else '')
        if kind is not None and kind.text.strip() in ('UDPv4', 'UDPv6'):
            for each in descriptor.children:
                _read_descriptor(each, findings)
        # A transport over shared memory is skipped silently: UDP reaches the same participants.
        elif kind is not None and kind.text.strip() != 'SHM':
            findings.ignore(f'transport {kind.text.strip()}')
    if 'UDPv6' in kinds and 'UDPv4' not in kinds:
        findings.values['ipv6'] = True


def _read_descriptor(element: Element, findings: Findings) -> None:
    """Read one setting of a UDP transport."""
    text = element.text.strip()
    match local_name(element):
        case 'transport_id' | 'type' | 'ttl':
            pass
        case 'interfacewhitelist':
            findings.interfaces += [child.text.strip() for child in element.children]
        case 'interfaces':
            for kind, names in (('allowlist', findings.interfaces), ('blocklist', findings.excluded)):
                listed = within(element, kind)
                for child in [] if listed is None else listed.children:
                    names.append(child.attributes.get('name', child.text.strip()))
        case 'maxmessagesize':
            findings.values['packet_size'] = min(findings.number(element, text, 1024, 1 << 30), _DATAGRAM)
        case 'receivebuffersize':
            findings.values['receive_buffer'] = findings.number(element, text, 1, 1 << 30)
        case 'sendbuffersize':
            findings.values['send_buffer'] = findings.number(element, text, 1, 1 << 30)
        case 'maxinitialpeersrange':
            findings.values['participants'] = findings.number(element, text, 1, MOST_PARTICIPANTS)
        case _:
            findings.ignore(f'transport_descriptor/{element.tag}')


# ---- the settings of a participant that are understood

_Reader = Callable[[Findings, Element], None]


def _locator(findings: Findings, element: Element) -> tuple[str, int]:
    """Return the address and the port of a locator, port 0 if it has none. Raises TransportError."""
    for kind in element.children:
        if local_name(kind) not in ('udpv4', 'udpv6'):
            findings.ignore(f'locator {kind.tag}')
            continue
        address, port = within(kind, 'address'), within(kind, 'port')
        number = 0 if port is None else findings.number(port, port.text.strip(), 0, 65535)
        return '' if address is None else address.text.strip(), number
    return '', 0


def _is_group(address: str) -> bool:
    if ':' in address:
        return address.lower().startswith('ff')
    first = address.partition('.')[0]
    return first.isdecimal() and 224 <= int(first) <= 239


def _peers(findings: Findings, element: Element) -> None:
    """Announce only to these peers. In Fast DDS the multicast group is a peer only if no other is named."""
    has_group = False
    for child in element.children:
        address, port = _locator(findings, child)
        if _is_group(address):
            has_group = True
            findings.values['group'] = address
        elif address:
            host = f'[{address}]' if ':' in address else address
            findings.peers.append(f'{host}:{port}' if port else host)
    findings.values['announces_to_group'] = has_group


def _unicast(findings: Findings, element: Element) -> None:
    """Listen at these addresses; then no multicast group is joined, unless one is named."""
    _own_addresses(findings, element)
    findings.values.setdefault('multicast', False)


def _own_addresses(findings: Findings, element: Element) -> None:
    for child in element.children:
        address, port = _locator(findings, child)
        if address:
            findings.interfaces.append(address)
        if port:
            findings.ignore(f'{element.tag}: port {port}')


def _group(findings: Findings, element: Element) -> None:
    for child in element.children:
        address, port = _locator(findings, child)
        if address:
            findings.values['group'], findings.values['multicast'] = address, True
        if port:
            findings.ignore(f'{element.tag}: port {port}')


def _protocol(findings: Findings, element: Element) -> None:
    protocol = element.text.strip().upper()
    if protocol == 'NONE':
        findings.values['reach'] = Reach.OFF
    elif protocol != 'SIMPLE':
        findings.ignore(f'discoveryProtocol {protocol} of {DISCOVERY_SERVER}')


def _builtin_transports(findings: Findings, element: Element) -> None:
    kind = element.text.strip().upper()
    if kind in ('UDPV6', 'DEFAULTV6'):
        findings.values['ipv6'] = True
    elif kind not in ('UDPV4', 'DEFAULT', 'SHM', ''):
        findings.ignore(f'builtinTransports {element.text.strip()}')


def _duration(field: str) -> _Reader:
    def read(findings: Findings, element: Element) -> None:
        seconds, rest = within(element, 'sec'), within(element, 'nanosec')
        text = '' if seconds is None else seconds.text.strip()
        if text.startswith('DURATION_INFINIT'):
            findings.values[field] = _LONGEST_S
            return
        whole = 0 if seconds is None else findings.number(seconds, text, 0, (1 << 31) - 1)
        part = 0 if rest is None else findings.number(rest, rest.text.strip(), 0, 999_999_999)
        if not whole and not part:
            raise findings.error(element, '0', 'a duration above 0, in sec and nanosec')
        findings.values[field] = min(whole + part / 1e9, _LONGEST_S)

    return read


def _number(field: str, most: int) -> _Reader:
    def read(findings: Findings, element: Element) -> None:
        findings.values[field] = findings.number(element, element.text.strip(), 0, most)

    return read


def _port(field: str) -> _Reader:
    def read(findings: Findings, element: Element) -> None:
        findings.ports[field] = findings.number(element, element.text.strip(), 0, 65535)

    return read


_READERS: dict[str, _Reader] = {
    'builtin/initialpeerslist': _peers,
    'builtin/metatrafficunicastlocatorlist': _unicast,
    'builtin/metatrafficmulticastlocatorlist': _group,
    'builtin/discovery_config/discoveryprotocol': _protocol,
    'builtin/discovery_config/leaseduration': _duration('lease_s'),
    'builtin/discovery_config/leaseannouncement': _duration('announce_s'),
    'defaultunicastlocatorlist': _own_addresses,
    'builtintransports': _builtin_transports,
    'listensocketbuffersize': _number('receive_buffer', 1 << 30),
    'sendsocketbuffersize': _number('send_buffer', 1 << 30),
    'participantid': _number('participant', MOST_PARTICIPANTS - 1),
    'port/portbase': _port('base'),
    'port/domainidgain': _port('domain_gain'),
    'port/participantidgain': _port('participant_gain'),
    'port/offsetd0': _port('multicast_discovery'),
    'port/offsetd1': _port('discovery'),
    'port/offsetd2': _port('multicast_data'),
    'port/offsetd3': _port('data'),
}
"""The readers of settings, by the path of their element below `rtps` in small letters."""
_WITHOUT_MEANING = {'name', 'userdata', 'usebuiltintransports', 'builtin/avoid_builtin_multicast'}
"""Elements that ROS 2 sets itself, or that ask for something goalwire always does."""
