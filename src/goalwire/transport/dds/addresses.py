"""Addresses of peers, made sure of before libddsc sees them.

The library looks peers up while it makes a domain, and ends the process where it cannot use one: abort()
for a name that does not resolve, a crash for 0.0.0.0. So the names of ROS_STATIC_PEERS are looked up here,
in bounded time, and the library is given numbers; the peers in CYCLONEDDS_URI are looked up to tell.
"""

from __future__ import annotations

import os
import re
import socket
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from queue import Empty, SimpleQueue

RESOLVE_WITHIN = 5.0
"""Seconds for the name service to find all peers of one configuration."""
_RESOLVERS = 16
_ENTRY = re.compile(
    r'(?:(?P<kind>\w+)/)?(?:\[(?P<v6>[^\[\]]*)\]|(?P<plain>[^\[\]/:]*))(?P<port>:[0-9]+)?', re.ASCII
)
_COMMENT = re.compile('<!--.*?-->', re.DOTALL)
_TAG = re.compile(r'<(/?)(\w+)((?:[^<>"\']|"[^"]*"|\'[^\']*\')*)>([^<]*)')
_ATTRIBUTE = re.compile(r'(\w+)\s*=\s*(?:"([^"]*)"|\'([^\']*)\')')
_VARIABLE = re.compile(r'\$\{(\w+)(?::-([^}]*))?\}')
_Answer = tuple[str, list[str]]


class Unusable(ValueError):
    """A peer that no packet can be sent to; the text says why."""


def loopback(ipv6: bool) -> str:
    """Return this machine's own address."""
    return '[::1]' if ipv6 else '127.0.0.1'


def resolve(entries: Iterable[str], ipv6: bool) -> dict[str, list[str] | Unusable]:
    """Return each entry's numeric addresses, as the library takes them, or why it has none.

    An entry is HOST, HOST:PORT, an IPv6 address, [ADDRESS]:PORT, each of them with udp/ or udp6/ before it
    if need be. All names are looked up at once, for RESOLVE_WITHIN seconds.
    """
    found: dict[str, list[str] | Unusable] = {}
    waiting: dict[str, list[tuple[str, str]]] = {}
    for entry in entries:
        try:
            host, port = _parts(entry, ipv6)
        except Unusable as error:
            found[entry] = error
            continue
        numeric = _look_up(host, ipv6, numeric=True)
        if numeric:
            found[entry] = _checked(host, numeric, port, ipv6)
        elif ':' in host or re.fullmatch('[0-9.]+', host):
            kind = 'IPv6' if ipv6 else 'IPv4'
            found[entry] = Unusable(f'it is no {kind} address, and Cyclone DDS speaks {kind} here')
        else:
            waiting.setdefault(host, []).append((entry, port))
    for host, addresses in _look_up_all(waiting, ipv6).items():
        for entry, port in waiting[host]:
            found[entry] = _checked(host, addresses, port, ipv6)
    for left in waiting.values():
        for entry, _ in left:
            found.setdefault(entry, Unusable(f'the name service did not answer in {RESOLVE_WITHIN:g} s'))
    return found


def configured_peers(uri: str, domain_id: int) -> tuple[list[str], bool]:
    """Return the peers that a CYCLONEDDS_URI names for a domain, and whether it asks for IPv6.

    Only what can be read here counts: the library itself complains of the rest, and does not abort there.
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


def _parts(entry: str, ipv6: bool) -> tuple[str, str]:
    """Split an entry into its host and its port with the colon; raises Unusable."""
    if entry != entry.strip():
        raise Unusable('it begins or ends with a blank')
    if entry.count(':') > 1 and '[' not in entry:
        entry = '[' + entry + ']'
    match = _ENTRY.fullmatch(entry)
    host = (match['v6'] or match['plain'] or '') if match else ''
    if match is None or not host or not host.isprintable() or len(host) > 253:
        raise Unusable('it is no address: write HOST, HOST:PORT or [IPV6]:PORT')
    if match['kind'] not in {None, 'udp6' if ipv6 else 'udp'}:
        raise Unusable(f"'{match['kind']}/' is not how Cyclone DDS speaks here")
    port = match['port'] or ''
    if port and not (len(port) <= 6 and 1 <= int(port[1:]) <= 65535):
        raise Unusable('its port is not 1 to 65535')
    if '%' in host:
        raise Unusable('Cyclone DDS takes no address with a scope')
    return host, port


def _checked(host: str, addresses: list[str], port: str, ipv6: bool) -> list[str] | Unusable:
    if not addresses:
        return Unusable(f"no {'IPv6' if ipv6 else 'IPv4'} address is known of '{host}'")
    if {'0.0.0.0', '::'} & set(addresses):  # noqa: S104  nothing is bound to it
        return Unusable('it means every address of this machine')
    return [f'[{address}]{port}' if ipv6 else address + port for address in addresses]


def _look_up(host: str, ipv6: bool, *, numeric: bool = False) -> list[str]:
    """Return the addresses of a host, none where it has none."""
    family = socket.AF_INET6 if ipv6 else socket.AF_INET
    flags = socket.AI_NUMERICHOST if numeric else 0
    try:
        answers = socket.getaddrinfo(host, None, family, socket.SOCK_DGRAM, flags=flags)
    except (OSError, UnicodeError):  # UnicodeError: no host name, its labels are too long
        return []
    return list(dict.fromkeys(str(answer[4][0]) for answer in answers))


def _look_up_all(hosts: Iterable[str], ipv6: bool) -> dict[str, list[str]]:
    """Look up names, several at once; those that take too long are left out."""
    left, answers = deque(hosts), SimpleQueue[_Answer]()
    count = len(left)

    def work() -> None:
        with suppress(IndexError):  # none is left
            while True:
                host = left.popleft()
                answers.put((host, _look_up(host, ipv6)))

    for _ in range(min(count, _RESOLVERS)):
        # getaddrinfo cannot be interrupted, and must not hold the program's end up
        threading.Thread(target=work, name='goalwire resolver', daemon=True).start()
    deadline = time.monotonic() + RESOLVE_WITHIN
    found: dict[str, list[str]] = {}
    try:
        while len(found) < count:
            host, addresses = answers.get(timeout=max(deadline - time.monotonic(), 0.0))
            found[host] = addresses
    except Empty:
        left.clear()
    return found


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
                continue  # the library will say so


def _expand(text: str) -> str:
    """Expand ${NAME} and ${NAME:-otherwise}, as the library does, and what XML writes for signs."""
    for sign, name in (('<', 'lt'), ('>', 'gt'), ('"', 'quot'), ("'", 'apos'), ('&', 'amp')):
        text = text.replace(f'&{name};', sign)
    return _VARIABLE.sub(lambda match: os.environ.get(match[1]) or match[2] or '', text)
