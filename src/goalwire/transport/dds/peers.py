"""Checks addresses of peers as people write them, and looks names up within bounded time."""

from __future__ import annotations

import re
import socket
import threading
import time
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, SimpleQueue

RESOLVE_WITHIN = 5.0
"""Seconds for the name service to find all peers of one configuration."""
_RESOLVERS = 16
_ENTRY = re.compile(
    r'(?:(?P<kind>\w+)/)?(?:\[(?P<v6>[^\[\]]*)\]|(?P<plain>[^\[\]/:]*))(?P<port>:[0-9]+)?', re.ASCII
)
_Answer = tuple[str, list[str]]


class Unusable(ValueError):
    """A peer that no packet can be sent to; the text says why. It becomes a warning or a TransportError."""


def resolve(entries: Iterable[str], ipv6: bool) -> dict[str, list[str] | Unusable]:
    """Return each entry's numeric addresses, as libraries take them, or why it has none.

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
            found[entry] = _check(host, numeric, port, ipv6)
        elif ':' in host or re.fullmatch('[0-9.]+', host):
            kind = 'IPv6' if ipv6 else 'IPv4'
            found[entry] = Unusable(f'it is no {kind} address, and {kind} is spoken here')
        else:
            waiting.setdefault(host, []).append((entry, port))
    for host, addresses in _look_up_all(waiting, ipv6).items():
        for entry, port in waiting[host]:
            found[entry] = _check(host, addresses, port, ipv6)
    for left in waiting.values():
        for entry, _ in left:
            found.setdefault(entry, Unusable(f'the name service did not answer in {RESOLVE_WITHIN:g} s'))
    return found


def _parts(entry: str, ipv6: bool) -> tuple[str, str]:
    """Split an entry into its host and ':PORT', which may be empty; raises Unusable."""
    if entry != entry.strip():
        raise Unusable('it begins or ends with a blank')
    if entry.count(':') > 1 and '[' not in entry:
        entry = '[' + entry + ']'
    match = _ENTRY.fullmatch(entry)
    host = (match['v6'] or match['plain'] or '') if match else ''
    if match is None or not host or not host.isprintable() or len(host) > 253:
        raise Unusable('it is not an address: write HOST, HOST:PORT or [IPV6]:PORT')
    if match['kind'] not in {None, 'udp6' if ipv6 else 'udp'}:
        raise Unusable(f"'{match['kind']}/' is not a transport of DDS here")
    port = match['port'] or ''
    if port and not (len(port) <= 6 and 1 <= int(port[1:]) <= 65535):
        raise Unusable('its port is not 1 to 65535')
    if '%' in host:
        raise Unusable('an address with a scope is not taken')
    return host, port


def _check(host: str, addresses: list[str], port: str, ipv6: bool) -> list[str] | Unusable:
    if not addresses:
        return Unusable(f"no {'IPv6' if ipv6 else 'IPv4'} address is known of '{host}'")
    if {'0.0.0.0', '::'} & set(addresses):  # noqa: S104  nothing is bound to it
        return Unusable('it means every address of this machine')
    return [f'[{address}]{port}' if ipv6 else address + port for address in addresses]


def _look_up(host: str, ipv6: bool, *, numeric: bool = False) -> list[str]:
    """Return the addresses of a host; an empty list if it cannot be resolved."""
    family = socket.AF_INET6 if ipv6 else socket.AF_INET
    flags = socket.AI_NUMERICHOST if numeric else 0
    try:
        answers = socket.getaddrinfo(host, None, family, socket.SOCK_DGRAM, flags=flags)
    except (OSError, UnicodeError):  # UnicodeError: a label is too long for a host name
        return []
    return list(dict.fromkeys(str(answer[4][0]) for answer in answers))


def _look_up_all(hosts: Iterable[str], ipv6: bool) -> dict[str, list[str]]:
    """Look up names, several at once; those that take too long are left out."""
    left, answers = deque(hosts), SimpleQueue[_Answer]()
    count = len(left)

    def work() -> None:
        with suppress(IndexError):  # all look-ups have ended
            while True:
                host = left.popleft()
                answers.put((host, _look_up(host, ipv6)))

    for _ in range(min(count, _RESOLVERS)):
        # daemon threads: getaddrinfo cannot be interrupted, and must not delay the end of the program
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
