"""Parameter lists: the discovery data of participants and endpoints, and the inline QoS of samples.

A parameter has an id, a length and a value of that many bytes. Ids from 0x8000 on are vendor-specific: each
vendor gives them another meaning. A reader that does not know an id with the bit 0x4000 must ignore the
participant or endpoint with that parameter; other unknown ids are skipped.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TypeAlias

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.messages import SENTINEL, TWO
from goalwire.rtps.protocol.primitives import LOCATOR, Address, RtpsError, SampleIdentity, decode_locator

PID_PAD = 0x0000
PARTICIPANT_LEASE = 0x0002
TOPIC_NAME, TYPE_NAME = 0x0005, 0x0007
DOMAIN_ID = 0x000F
PROTOCOL_VERSION, VENDOR_ID = 0x0015, 0x0016
RELIABILITY, LIVELINESS_QOS, DURABILITY = 0x001A, 0x001B, 0x001D
DURABILITY_SERVICE, OWNERSHIP = 0x001E, 0x001F
DEADLINE, PARTITION, LIFESPAN, USER_DATA = 0x0023, 0x0029, 0x002B, 0x002C
UNICAST_LOCATOR, DEFAULT_UNICAST, METATRAFFIC_UNICAST = 0x002F, 0x0031, 0x0032
HISTORY = 0x0040
PARTICIPANT_GUID, BUILTIN_ENDPOINTS, ENDPOINT_GUID = 0x0050, 0x0058, 0x005A
ENTITY_NAME = 0x0062
KEY_HASH, STATUS_INFO = 0x0070, 0x0071
REPRESENTATION = 0x0073
RELATED_SAMPLE, RELATED_SAMPLE_OF_VENDORS = 0x0083, 0x800F
"""The ids of the parameter that names a reply's request: the standard's, and one of older programs."""
DOMAIN_TAG = 0x4014
RECEIVE_BUFFER = 0x8002
"""A parameter of this implementation's participants: the bytes that the system keeps of unread packets."""

VENDORS, MUST_BE_KNOWN = 0x8000, 0x4000

LITTLE_LIST, BIG_LIST = b'\0\3', b'\0\2'
"""The encapsulation header of a payload that is a parameter list."""
DISPOSED, UNREGISTERED = 0x01, 0x02
"""Bits of STATUS_INFO: the instance was disposed of, or its writer has unregistered it."""

Parameters: TypeAlias = list[tuple[int, bytes]]

_IDENTITY = struct.Struct('<16siI')
new_identity: Callable[[tuple[bytes, int]], SampleIdentity] = partial(tuple.__new__, SampleIdentity)
"""Makes a SampleIdentity in C code, which is faster than a call of the class."""
_NOBODY = -1
"""The sequence number of a sample identity that names no sample."""


def read_list(data: bytes, at: int = 0, order: int = 1) -> Parameters:
    """Read the parameter list at `at`; it may end with the data instead of a sentinel. Raises RtpsError."""
    found: Parameters = []
    two, end = TWO[order], len(data)
    while end - at >= 4:
        pid, size = two.unpack_from(data, at)
        at += 4
        if pid == SENTINEL:
            break
        if size > end - at:
            raise RtpsError(f'parameter 0x{pid:04x} of {size} bytes is cut off')
        if len(found) == bounds.MOST_PARAMETERS:
            raise RtpsError(f'a list has more than {bounds.MOST_PARAMETERS} parameters')
        if pid != PID_PAD:
            found.append((pid, data[at : at + size]))
        at += size
    return found


def write_list(parameters: Iterable[tuple[int, bytes]]) -> bytes:
    """Return a parameter list with its sentinel; each value is padded to a multiple of four bytes."""
    parts = []
    for pid, value in parameters:
        padded = value + bytes(-len(value) & 3)
        parts.append(TWO[1].pack(pid, len(padded)) + padded)
    parts.append(TWO[1].pack(SENTINEL, 0))
    return b''.join(parts)


def read_payload(payload: bytes) -> tuple[Parameters, int]:
    """Read a payload that is a parameter list; return the list and its byte order. Raises RtpsError."""
    kind = payload[:2]
    if kind not in (LITTLE_LIST, BIG_LIST):
        raise RtpsError(f'a payload begins with {kind.hex()}, and a parameter list was expected')
    order = kind[1] & 1
    return read_list(payload, 4, order), order


def write_payload(parameters: Iterable[tuple[int, bytes]]) -> bytes:
    """Return a payload that is a parameter list."""
    return LITTLE_LIST + b'\0\0' + write_list(parameters)


def write_text(text: str) -> bytes:
    """Return a text as a parameter's value: its length with the NUL, then the text and the NUL."""
    data = text.encode() + b'\0'
    return struct.pack('<I', len(data)) + data


def read_text(value: bytes, order: int, most: int = bounds.TEXT_SIZE) -> str:
    """Read a text; raises RtpsError if it is cut off, longer than `most` bytes, or not UTF-8."""
    data = read_bytes(value, order, most)
    try:
        return data.rstrip(b'\0').decode()
    except UnicodeDecodeError as error:
        raise RtpsError(f'a text is not UTF-8: {error}') from None


def read_bytes(value: bytes, order: int, most: int) -> bytes:
    """Read a length and that many bytes; raises RtpsError if they are cut off, or more than `most`."""
    size = read_u32(value, order)
    if size > len(value) - 4 or size > most:
        raise RtpsError(f'data of {size} bytes stand in a parameter of {len(value)}')
    return value[4 : 4 + size]


def read_u32(value: bytes, order: int) -> int:
    """Read the 32-bit number at the beginning of a value; raises RtpsError if it is cut off."""
    if len(value) < 4:
        raise RtpsError(f'a parameter has {len(value)} bytes, and a number was expected')
    return int.from_bytes(value[:4], 'little' if order else 'big')


def read_texts(value: bytes, order: int) -> tuple[str, ...]:
    """Read a sequence of texts; raises RtpsError if it is malformed."""
    count = read_u32(value, order)
    if count > bounds.MOST_PARTITIONS:
        raise RtpsError(f'a parameter has {count} texts')
    at, texts = 4, []
    for _ in range(count):
        texts.append(read_text(value[at:], order, 256))
        size = read_u32(value[at:], order)
        at += 4 + size + (-size & 3)
    return tuple(texts)


def write_texts(texts: tuple[str, ...]) -> bytes:
    """Return a sequence of texts as a parameter's value."""
    parts = [struct.pack('<I', len(texts))]
    for text in texts:
        data = write_text(text)
        parts.append(data + bytes(-len(data) & 3))
    return b''.join(parts)


def read_address(value: bytes, order: int) -> Address | None:
    """Return the address in a locator; None if its kind cannot be used here. Raises RtpsError."""
    if len(value) < LOCATOR.size:
        raise RtpsError(f'a locator has {len(value)} bytes')
    kind, port, address = (LOCATOR if order else _BIG_LOCATOR).unpack_from(value)
    return decode_locator(kind, port, address)


_BIG_LOCATOR = struct.Struct('>iI16s')


def read_related_sample(qos: bytes) -> SampleIdentity | None:
    """Return the identity of the request that a sample's inline QoS names; None if it names no request."""
    if qos[:4] == _RELATED_HEAD and len(qos) >= 28:  # most inline QoS begins with these parameters
        guid, high, low = _IDENTITY.unpack_from(qos, 4)
        return new_identity((guid, (high << 32) | low if high >= 0 else _NOBODY))
    for pid, value in read_list(qos):
        if pid in (RELATED_SAMPLE, RELATED_SAMPLE_OF_VENDORS) and len(value) >= _IDENTITY.size:
            guid, high, low = _IDENTITY.unpack_from(value)
            return SampleIdentity(guid, (high << 32) | low if high >= 0 else _NOBODY)
    return None


def write_related_sample(related: SampleIdentity, others: Sequence[tuple[int, bytes]] = ()) -> bytes:
    """Return inline QoS that names a request by both parameter ids (standard and older), then `others`."""
    guid, number = related
    value = _IDENTITY.pack(guid, number >> 32, number & 0xFFFFFFFF if number >= 0 else 0)
    rest = write_list(others) if others else _END
    return b'%b%b%b%b%b' % (_RELATED_HEAD, value, _VENDORS_RELATED_HEAD, value, rest)


_RELATED_HEAD = struct.pack('<HH', RELATED_SAMPLE, _IDENTITY.size)
_VENDORS_RELATED_HEAD = struct.pack('<HH', RELATED_SAMPLE_OF_VENDORS, _IDENTITY.size)
_END = struct.pack('<HH', SENTINEL, 0)
RELATED_SAMPLE_ALONE = struct.Struct('<4s24x4s24x4s')
"""The parameters' heads in inline QoS that names only a request, in the form that all vendors write."""
HEADS_OF_RELATED_SAMPLE = _RELATED_HEAD, _VENDORS_RELATED_HEAD, _END
"""The values of these heads."""


def status_of(qos: bytes) -> tuple[int, bytes]:
    """Return the bits of STATUS_INFO and the key hash of inline QoS; 0 and b'' if they are missing."""
    status, key = 0, b''
    for pid, value in read_list(qos):
        if pid == STATUS_INFO and len(value) >= 4:
            status = value[3]
        elif pid == KEY_HASH and len(value) == 16:
            key = value
    return status, key


def write_status(status: int, key: bytes) -> bytes:
    """Return inline QoS that says that an instance was disposed of or unregistered."""
    return write_list([(KEY_HASH, key), (STATUS_INFO, bytes((0, 0, 0, status)))])
