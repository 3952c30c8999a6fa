"""GUIDs, sequence numbers, sets of them, times and addresses: the parts of every submessage.

A GUID names a participant, a writer or a reader: twelve bytes that a participant chooses (its *prefix*), and
four of an *entity id* within it. The last byte of an entity id tells the kind of entity. GUIDs and their
parts are `bytes` here, in the order of the wire, so that they can be keys of tables as they are.

A sequence number has 64 bits and begins at 1. On the wire its signed high half comes first, then its low
half. A time on the wire has seconds since 1970 and a fraction in units of 2**-32 s; in this package a time is
in nanoseconds.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from socket import AF_INET6, inet_ntop, inet_pton
from typing import NamedTuple, TypeAlias

from goalwire.errors import RemoteError
from goalwire.rtps.protocol import bounds

Address: TypeAlias = tuple[str, int]
"""Host and UDP port, as sockets take them."""

PacketParts: TypeAlias = tuple[bytes | memoryview, ...]
"""A packet in pieces. A large payload is one of them, and stays where it is until the system copies it."""

LARGE = 4096
"""A packet with more bytes than this most likely holds a fragment, so that others follow."""

PREFIX_SIZE = 12
GUID_SIZE = 16

UNKNOWN_ENTITY = b'\0\0\0\0'
PARTICIPANT = b'\0\0\1\xc1'
SPDP_WRITER, SPDP_READER = b'\0\1\0\xc2', b'\0\1\0\xc7'
PUBLICATIONS_WRITER, PUBLICATIONS_READER = b'\0\0\3\xc2', b'\0\0\3\xc7'
SUBSCRIPTIONS_WRITER, SUBSCRIPTIONS_READER = b'\0\0\4\xc2', b'\0\0\4\xc7'
MESSAGE_WRITER, MESSAGE_READER = b'\0\2\0\xc2', b'\0\2\0\xc7'
"""Entity ids for participant messages, which say that a participant's writers are alive."""

WRITER_KIND, READER_KIND = 0x03, 0x04
"""The last byte of entity ids of writers and readers of topics without key."""

UNKNOWN_PREFIX = bytes(PREFIX_SIZE)

NS = 1_000_000_000
INFINITE = 2**63 - 1
"""Nanoseconds that stand for an infinite duration."""
_INFINITE_SECONDS = 0x7FFFFFFF

UDP_V4, UDP_V6 = 1, 2
"""The kinds of locators that are used here. Others (shared memory, TCP) are skipped."""
LOCATOR = struct.Struct('<iI16s')


class RtpsError(RemoteError):
    """An error for a packet that breaks the rules of RTPS; the rest of the packet is ignored."""


class SampleIdentity(NamedTuple):
    """The identity of a sample: the GUID of its writer or reader, and its number (-1: unknown)."""

    guid: bytes
    number: int


def is_writer(entity_id: bytes) -> bool:
    """Return True if an entity id is a writer's."""
    return entity_id[3] & 0x3F in (0x02, 0x03)


def is_keyed(entity_id: bytes) -> bool:
    """Return True if an entity id is that of a writer or reader of a topic with a key."""
    return entity_id[3] & 0x3F in (0x02, 0x07)


def encode_duration(ns: int, order: str = '<') -> bytes:
    """Return the eight bytes of a duration in nanoseconds; INFINITE becomes the largest value."""
    if ns >= INFINITE:
        return struct.pack(f'{order}iI', _INFINITE_SECONDS, 0xFFFFFFFF)
    return struct.pack(f'{order}iI', *_split(ns))


def decode_duration(seconds: int, fraction: int) -> int:
    """Return a duration in nanoseconds. A duration whose seconds have the largest value is infinite."""
    return INFINITE if seconds == _INFINITE_SECONDS else seconds * NS + _fraction_ns(fraction)


def _split(ns: int) -> tuple[int, int]:
    """Split nanoseconds into seconds and a fraction (2**-32 s) that decode to the same nanoseconds."""
    seconds, rest = divmod(ns, NS)
    return min(seconds, _INFINITE_SECONDS - 1), ((rest << 32) + NS - 1) // NS


def _fraction_ns(fraction: int) -> int:
    return fraction * NS >> 32


def encode_time(ns: int) -> bytes:
    """Return a time in ns since 1970 as INFO_TS's eight bytes; rounding up keeps each ns."""
    seconds, rest = divmod(ns, NS)
    return _TIME.pack(seconds & 0xFFFFFFFF, ((rest << 32) + NS - 1) // NS)


def decode_time(seconds: int, fraction: int) -> int:
    """Return the time that seconds and a fraction (2**-32 s) mean, in nanoseconds since 1970."""
    return seconds * NS + (fraction * NS >> 32)


_TIME = struct.Struct('<II')


class NumberSet(NamedTuple):
    """A set of numbers in ACKNACK, GAP and NACK_FRAG: a base, and up to 256 bits for the numbers from it on.

    `words` are the bits in words of 32; the first number is the highest bit of the first word. Some
    implementations set bits beyond the length `bits`. Those bits are kept, so that encoding gives the same
    bytes.
    """

    base: int
    bits: int = 0
    words: tuple[int, ...] = ()

    @classmethod
    def of(cls, base: int, numbers: Iterable[int]) -> NumberSet:
        """Return the set of those `numbers` that are below `base` + 256; all must be at least `base`."""
        words = [0] * (bounds.SET_BITS // 32)
        bits = 0
        for number in numbers:
            at = number - base
            if at < bounds.SET_BITS:
                words[at >> 5] |= 0x80000000 >> (at & 31)
                bits = max(bits, at + 1)
        return cls(base, bits, tuple(words[: (bits + 31) >> 5]))

    def numbers(self) -> list[int]:
        """Return the numbers of the set, in order."""
        base, words = self.base, self.words
        return [base + at for at in range(self.bits) if words[at >> 5] & (0x80000000 >> (at & 31))]


def is_ipv6(host: str) -> bool:
    """Return True if a host is an IPv6 address."""
    return ':' in host


def decode_locator(kind: int, port: int, address: bytes) -> Address | None:
    """Return the address in a locator; None if the locator is not UDP, or its address is not usable."""
    if not 0 < port < 65536:
        return None
    if kind == UDP_V4 and address[12:] != b'\0\0\0\0':
        return '{}.{}.{}.{}'.format(*address[12:]), port
    if kind == UDP_V6 and address != bytes(16):
        return inet_ntop(AF_INET6, address), port
    return None


def encode_locator(address: Address) -> bytes:
    """Return the locator of an address and a port: 24 bytes."""
    host, port = address
    if is_ipv6(host):
        return LOCATOR.pack(UDP_V6, port, inet_pton(AF_INET6, host.partition('%')[0]))
    return LOCATOR.pack(UDP_V4, port, bytes(12) + bytes(map(int, host.split('.'))))
