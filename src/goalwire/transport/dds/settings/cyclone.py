"""CYCLONEDDS_URI: XML in the variable, names of files, or several of either with commas between them.

Source: Cyclone DDS, docs/manual/options.md, src/core/ddsi/src/ddsi_config.c and src/ddsrt/src/xmlparser.c.
Names of elements and attributes are read in any case, `</>` closes any element, `${NAME:-otherwise}` stands
for a variable, and the elements CycloneDDS and Domain may be left out.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping

from goalwire.patterns import Pattern
from goalwire.rtps.io.addresses import MOST_PARTICIPANTS
from goalwire.transport.dds.settings.findings import Findings, local_name
from goalwire.xml_tree import Element

_ORIGIN = 'CYCLONEDDS_URI'

_MARK = Pattern(r'<!--.*?-->|<\?.*?\?>|<(/?)([\w:.|-]*)((?:[^<>"\']|"[^"]*"|\'[^\']*\')*)>', 16)  # re.DOTALL
_VARIABLE = Pattern(r'\$\{(\w+)(?::-([^}]*))?\}')
_SIZE = Pattern(r'([0-9]{1,9})\s*(B|kB|KiB|MB|MiB|GB|GiB)', 2)  # re.IGNORECASE
_DURATION = Pattern(r'([0-9]{1,9}(?:\.[0-9]{1,9})?)\s*(ns|us|ms|s|min|hr|day)')
_UNITS = {'b': 1, 'kb': 1 << 10, 'kib': 1 << 10, 'mb': 1 << 20, 'mib': 1 << 20, 'gb': 1 << 30, 'gib': 1 << 30}
_SECONDS = {'ns': 1e-9, 'us': 1e-6, 'ms': 1e-3, 's': 1.0, 'min': 60.0, 'hr': 3600.0, 'day': 86400.0}
_LONGEST_S = 10 * 365 * 86400.0
"""The word for an infinite duration."""


def read_cyclone(uri: str, domain: int, env: Mapping[str, str] = os.environ) -> Findings:
    """Read the part of a CYCLONEDDS_URI that applies to a domain. Raises TransportError."""
    findings = Findings(_ORIGIN)
    for text in _documents(uri, findings):
        root = findings.parse(text)
        for section in _of_domain(root, domain):
            _read_section(section, (), findings, env)
    return findings


def _documents(uri: str, findings: Findings) -> Iterator[str]:
    """Yield each XML document that is in the variable, or in a file that it names."""
    rest = uri.strip(' \t\r\n,')
    while rest:
        if rest.startswith('<'):
            text, rest = _take_document(rest)
            yield text
        else:
            path, _, rest = rest.partition(',')
            content = findings.read_file(path.strip().removeprefix('file://'))
            yield _take_document(content.decode(errors='replace').strip())[0]
        rest = rest.strip(' \t\r\n,')


def _take_document(text: str) -> tuple[str, str]:
    """Split a text after its first outermost element, and replace each `</>` by the full closing tag."""
    parts: list[str] = []
    is_open: list[str] = []
    at = 0
    for mark in _MARK.finditer(text):
        parts.append(text[at : mark.start()])
        at = mark.end()
        whole, ends, tag, rest = mark[0], mark[1], mark[2], mark[3]
        if tag is None:  # a comment
            parts.append(whole)
            continue
        if ends:
            opened = is_open.pop() if is_open else tag
            parts.append(f'</{tag or opened}>')
        else:
            parts.append(whole)
            if not rest.endswith('/'):
                is_open.append(tag)
        if not is_open:
            return ''.join(parts), text[at:]
    return text, ''  # the XML reader will report the error


def _of_domain(root: Element, domain: int) -> Iterator[Element]:
    """Yield the elements General, Discovery and so on that hold for a domain."""
    name = local_name(root)
    if name == 'cyclonedds':
        for child in root.children:
            yield from _of_domain(child, domain)
    elif name == 'domain':
        wanted = _attributes(root).get('id', 'any').strip().lower()
        if wanted in ('any', 'default', '', str(domain)):
            yield from root.children
    else:
        yield root


def _read_section(
    element: Element, parents: tuple[str, ...], findings: Findings, env: Mapping[str, str]
) -> None:
    """Read an element or its children; note the paths of unknown ones."""
    path = (*parents, element.tag)
    read = _READERS.get('/'.join(path).lower())
    if read is not None:
        attributes = {key: _expand(value, env) for key, value in _attributes(element).items()}
        read(findings, element, _expand(element.text, env).strip(), attributes)
    elif element.children:
        for child in element.children:
            _read_section(child, path, findings, env)
    elif element.text.strip() or element.attributes or len(path) > 1:
        findings.ignore('/'.join(path))


def _attributes(element: Element) -> dict[str, str]:
    return {key.lower(): value for key, value in element.attributes.items()}


def _expand(text: str, env: Mapping[str, str]) -> str:
    return _VARIABLE.sub(lambda match: env.get(match[1]) or match[2] or '', text)


# ---- the settings that are understood

_Reader = Callable[[Findings, Element, str, dict[str, str]], None]


def _interface(findings: Findings, element: Element, _: str, attributes: dict[str, str]) -> None:
    named = attributes.get('name') or attributes.get('address')
    if named:
        findings.interfaces.append(named)
    if attributes.get('multicast', 'default').lower() not in ('default', ''):
        findings.values['multicast'] = findings.boolean(element, attributes['multicast'])


def _interface_addresses(findings: Findings, _: Element, text: str, _attributes: dict[str, str]) -> None:
    findings.interfaces += [part for each in text.split(',') if (part := each.strip()) not in ('', 'auto')]


def _multicast(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
    parts = [part.strip().lower() for part in text.split(',')]
    if parts[0] in ('default', ''):
        return
    if {*parts} <= {'spdp', 'asm', 'ssm'}:  # goalwire uses multicast only for discovery
        findings.values['multicast'] = bool({'spdp', 'asm'} & {*parts})
    else:
        findings.values['multicast'] = findings.boolean(element, text)


def _transport(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
    if text.lower() in ('udp', 'udp6', 'default', ''):
        findings.values['ipv6'] = text.lower() == 'udp6'
    else:
        raise findings.error(element, text, 'udp or udp6, which are the transports here')


def _use_ipv6(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
    if text.lower() not in ('default', ''):
        findings.values['ipv6'] = findings.boolean(element, text)


def _index(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
    if text.lower() not in ('auto', 'none', 'default', ''):
        findings.values['participant'] = findings.number(element, text, 0, MOST_PARTICIPANTS - 1)


def _most_index(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
    findings.values['participants'] = 1 + findings.number(element, text, 0, MOST_PARTICIPANTS - 1)


def _peer(findings: Findings, _: Element, _text: str, attributes: dict[str, str]) -> None:
    findings.peers += [part for each in attributes.get('address', '').split(',') if (part := each.strip())]


def _group(findings: Findings, _: Element, text: str, _attributes: dict[str, str]) -> None:
    if text:
        findings.values['group'] = text


def _tag(findings: Findings, _: Element, text: str, _attributes: dict[str, str]) -> None:
    findings.values['tag'] = text


def _port(field: str) -> _Reader:
    def read(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
        findings.ports[field] = findings.number(element, text, 0, 65535)

    return read


def _duration(field: str) -> _Reader:
    def read(findings: Findings, element: Element, text: str, _: dict[str, str]) -> None:
        if text.lower() in ('default', ''):
            return
        match = _DURATION.fullmatch(text)
        if text.lower() == 'inf':
            seconds = _LONGEST_S
        elif match is None or not float(match[1]):
            raise findings.error(element, text, 'a duration as 10s or 500ms')
        else:
            seconds = min(float(match[1]) * _SECONDS[match[2]], _LONGEST_S)
        findings.values[field] = seconds

    return read


def _size(field: str, least: int) -> _Reader:
    """Read a size from the text, or for buffers from the attributes min and max."""

    def read(findings: Findings, element: Element, text: str, attributes: dict[str, str]) -> None:
        for one in (attributes.get('max', ''), attributes.get('min', ''), text):
            if one.strip().lower() in ('default', ''):
                continue
            match = _SIZE.fullmatch(one.strip())
            size = int(match[1]) * _UNITS[match[2].lower()] if match is not None else 0
            if size < least:
                raise findings.error(element, one, f'a size of at least {least} B, as 10MB or 65500B')
            findings.values[field] = size
            return

    return read


_LEAST_PACKET = 1024
"""The smallest size of a packet that is accepted, in bytes; an announcement has some 500 bytes."""
_DATAGRAM = 65_507


def _packet(findings: Findings, element: Element, text: str, attributes: dict[str, str]) -> None:
    before = findings.values.get('packet_size')
    _size('packet_size', _LEAST_PACKET)(findings, element, text, attributes)
    sizes = [
        size for size in (before, findings.values.get('packet_size'), _DATAGRAM) if isinstance(size, int)
    ]
    if len(sizes) > 1:
        findings.values['packet_size'] = min(sizes)


_READERS: dict[str, _Reader] = {
    'general/interfaces/networkinterface': _interface,
    'general/networkinterfaceaddress': _interface_addresses,
    'general/allowmulticast': _multicast,
    'general/transport': _transport,
    'general/useipv6': _use_ipv6,
    'general/maxmessagesize': _packet,
    'general/fragmentsize': _packet,
    'discovery/participantindex': _index,
    'discovery/maxautoparticipantindex': _most_index,
    'discovery/peers/peer': _peer,
    'discovery/spdpmulticastaddress': _group,
    'discovery/spdpinterval': _duration('announce_s'),
    'discovery/leaseduration': _duration('lease_s'),
    'discovery/tag': _tag,
    'discovery/ports/base': _port('base'),
    'discovery/ports/domaingain': _port('domain_gain'),
    'discovery/ports/participantgain': _port('participant_gain'),
    'discovery/ports/multicastmetaoffset': _port('multicast_discovery'),
    'discovery/ports/multicastdataoffset': _port('multicast_data'),
    'discovery/ports/unicastmetaoffset': _port('discovery'),
    'discovery/ports/unicastdataoffset': _port('data'),
    'internal/socketreceivebuffersize': _size('receive_buffer', 1),
    'internal/minimumsocketreceivebuffersize': _size('receive_buffer', 1),
    'internal/socketsendbuffersize': _size('send_buffer', 1),
    'internal/minimumsocketsendbuffersize': _size('send_buffer', 1),
}
"""The readers of settings, by the path of their element in small letters."""
