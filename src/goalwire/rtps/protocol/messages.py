"""Writes and reads RTPS messages: a header, followed by submessages.

A packet is 20 bytes of header, then submessages. Each submessage begins with its id, its flags and its
length; a submessage with an unknown id is skipped. Some submessages describe those that follow: INFO_DST
names the participant that gets them, INFO_TS the time at which a sample was written. The bodies of the other
submessages are records here: `read` decodes a record from bytes, and `encode` returns the bytes. Little
endian is written; both byte orders are read.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.primitives import NumberSet, PacketParts, RtpsError

MAGIC = b'RTPS'
VERSION = b'\x02\x05'
VENDOR = b'\x01\xe7'
"""The vendor id of this implementation. It is not an assigned one: peers of an assigned vendor would take it
for one of their own and use that vendor's extensions."""
HEADER_SIZE = 20

PAD, ACKNACK, HEARTBEAT, GAP = 0x01, 0x06, 0x07, 0x08
INFO_TS, INFO_SRC, INFO_DST = 0x09, 0x0C, 0x0E
NACK_FRAG, HEARTBEAT_FRAG, DATA, DATA_FRAG = 0x12, 0x13, 0x15, 0x16

LITTLE = 0x01
"""The flag of each little-endian submessage."""
INLINE_QOS, WITH_DATA, WITH_KEY = 0x02, 0x04, 0x08
"""Flags of DATA: it has inline QoS; its payload is a sample, or the key of one."""
KEY_FRAGMENTS = 0x04
"""Flag of DATA_FRAG: the fragments are those of a key."""
FINAL, LIVELINESS = 0x02, 0x04
"""Flags of HEARTBEAT and ACKNACK: no answer is needed; of HEARTBEAT: it asserts that the writer lives."""
INVALIDATE = 0x02
"""Flag of INFO_TS: the following submessages have no time."""

_ORDERS = '><'
_HEAD = struct.Struct('<BBH')
_DATA = [struct.Struct(f'{order}HH4s4siI') for order in _ORDERS]
_DATA_FRAG = [struct.Struct(f'{order}HH4s4siIIHHI') for order in _ORDERS]
_HEARTBEAT = [struct.Struct(f'{order}4s4siIiIi') for order in _ORDERS]
_HEARTBEAT_FRAG = [struct.Struct(f'{order}4s4siIIi') for order in _ORDERS]
_SET_HEAD = [struct.Struct(f'{order}4s4siII') for order in _ORDERS]
_GAP_HEAD = [struct.Struct(f'{order}4s4siIiII') for order in _ORDERS]
_NACK_FRAG_HEAD = [struct.Struct(f'{order}4s4siIII') for order in _ORDERS]
_COUNT = [struct.Struct(f'{order}i') for order in _ORDERS]
_WORDS = [[struct.Struct(f'{order}{count}I') for count in range(9)] for order in _ORDERS]
TIME = [struct.Struct(f'{order}II') for order in _ORDERS]

_BEFORE_QOS = 16
"""Bytes of DATA between the field octetsToInlineQos and the inline QoS."""
_BEFORE_FRAGMENT_QOS = 28


class Data(NamedTuple):
    """DATA: a sample, or the notice that an instance was disposed of.

    `qos`: inline QoS with its sentinel, or empty.
    """

    reader: bytes
    writer: bytes
    number: int
    qos: bytes = b''
    payload: bytes | None = None
    is_key: bool = False

    @classmethod
    def read(cls, data: bytes, at: int, end: int, flags: int) -> Data:
        """Read the body that stands from `at` to `end`."""
        order = flags & LITTLE
        _, before, reader, writer, high, low = _DATA[order].unpack_from(data, at)
        at += 4 + before
        qos = b''
        if flags & INLINE_QOS:
            qos_end = skip_parameters(data, at, end, order)
            qos = data[at:qos_end]
            at = qos_end
        number = (high << 32) | low
        if before < _BEFORE_QOS or at > end or number < 1:
            raise RtpsError(f'DATA {number} begins {before} bytes behind its head')
        payload = data[at:end] if flags & (WITH_DATA | WITH_KEY) else None
        return cls(reader, writer, number, qos, payload, bool(flags & WITH_KEY))

    def encode(self) -> bytes:
        """Return the submessage."""
        number, qos, payload = self.number, self.qos, self.payload
        flags = LITTLE | INLINE_QOS if qos else LITTLE
        if payload is None:
            payload = b''
        else:
            flags |= WITH_KEY if self.is_key else WITH_DATA
        body = _DATA[1].pack(0, _BEFORE_QOS, self.reader, self.writer, number >> 32, number & 0xFFFFFFFF)
        return submessage(DATA, flags, body + qos + payload)


class DataFrag(NamedTuple):
    """DATA_FRAG: some fragments of a sample, counted from 1; `size` is the size of the whole sample."""

    reader: bytes
    writer: bytes
    number: int
    first: int
    fragments: int
    fragment_size: int
    size: int
    qos: bytes = b''
    payload: bytes | memoryview = b''
    is_key: bool = False

    @classmethod
    def read(cls, data: bytes, at: int, end: int, flags: int) -> DataFrag:
        """Read the body that stands from `at` to `end`."""
        order = flags & LITTLE
        fields = _DATA_FRAG[order].unpack_from(data, at)
        _, before, reader, writer, high, low, first, count, fragment_size, size = fields
        at += 4 + before
        qos = b''
        if flags & INLINE_QOS:
            qos_end = skip_parameters(data, at, end, order)
            qos = data[at:qos_end]
            at = qos_end
        number = (high << 32) | low
        if before < _BEFORE_FRAGMENT_QOS or at > end or number < 1:
            raise RtpsError(f'DATA_FRAG {number} begins {before} bytes behind its head')
        is_key = bool(flags & KEY_FRAGMENTS)
        return cls(reader, writer, number, first, count, fragment_size, size, qos, data[at:end], is_key)

    def encode(self) -> bytes:
        """Return the submessage."""
        return b''.join(self.parts())

    def parts(self, before: bytes = b'') -> PacketParts:
        """Return a packet in parts: its beginning `before` and this submessage. The payload is not copied."""
        number, payload = self.number, self.payload
        flags = LITTLE | (INLINE_QOS if self.qos else 0) | (KEY_FRAGMENTS if self.is_key else 0)
        body = _DATA_FRAG[1].pack(
            0,
            _BEFORE_FRAGMENT_QOS,
            self.reader,
            self.writer,
            number >> 32,
            number & 0xFFFFFFFF,
            self.first,
            self.fragments,
            self.fragment_size,
            self.size,
        )
        size = len(body) + len(self.qos) + len(payload)
        pad = -size & 3
        head = _HEAD.pack(DATA_FRAG, flags, size + pad if size + pad < 65536 else 0)
        return b'%b%b%b%b' % (before, head, body, self.qos), payload, b'\0\0\0'[:pad]


class Heartbeat(NamedTuple):
    """HEARTBEAT: a writer has the samples from `first` to `last`; if it has none, `first` is `last` + 1."""

    reader: bytes
    writer: bytes
    first: int
    last: int
    counter: int
    is_final: bool = False
    asserts_liveliness: bool = False

    @classmethod
    def read(cls, data: bytes, at: int, _end: int, flags: int) -> Heartbeat:
        """Read the body that stands at `at`."""
        fields = _HEARTBEAT[flags & LITTLE].unpack_from(data, at)
        reader, writer, first_high, first_low, last_high, last_low, count = fields
        first, last = (first_high << 32) | first_low, (last_high << 32) | last_low
        if first < 1 or last < first - 1:
            raise RtpsError(f'a HEARTBEAT tells of the samples {first} to {last}')
        return cls(reader, writer, first, last, count, bool(flags & FINAL), bool(flags & LIVELINESS))

    def encode(self) -> bytes:
        """Return the submessage."""
        flags = LITTLE | (FINAL if self.is_final else 0) | (LIVELINESS if self.asserts_liveliness else 0)
        first, last = self.first, self.last
        body = _HEARTBEAT[1].pack(
            self.reader,
            self.writer,
            first >> 32,
            first & 0xFFFFFFFF,
            last >> 32,
            last & 0xFFFFFFFF,
            self.counter,
        )
        return submessage(HEARTBEAT, flags, body)


class AckNack(NamedTuple):
    """ACKNACK: a reader has all samples below `missing.base`, and requests the samples in `missing`."""

    reader: bytes
    writer: bytes
    missing: NumberSet
    counter: int
    is_final: bool = False

    @classmethod
    def read(cls, data: bytes, at: int, end: int, flags: int) -> AckNack:
        """Read the body that stands from `at` to `end`."""
        order = flags & LITTLE
        reader, writer, high, low, bits = _SET_HEAD[order].unpack_from(data, at)
        words, at = _read_words(data, at + 20, end, order, bits)
        missing = NumberSet((high << 32) | low, bits, words)
        return cls(reader, writer, missing, _COUNT[order].unpack_from(data, at)[0], bool(flags & FINAL))

    def encode(self) -> bytes:
        """Return the submessage."""
        base, bits, words = self.missing
        body = _SET_HEAD[1].pack(self.reader, self.writer, base >> 32, base & 0xFFFFFFFF, bits)
        body += _WORDS[1][len(words)].pack(*words) + _COUNT[1].pack(self.counter)
        return submessage(ACKNACK, LITTLE | FINAL if self.is_final else LITTLE, body)


class Gap(NamedTuple):
    """GAP: the samples from `first` to `irrelevant.base` - 1, and those in `irrelevant`, will not come."""

    reader: bytes
    writer: bytes
    first: int
    irrelevant: NumberSet

    @classmethod
    def read(cls, data: bytes, at: int, end: int, flags: int) -> Gap:
        """Read the body that stands from `at` to `end`."""
        order = flags & LITTLE
        fields = _GAP_HEAD[order].unpack_from(data, at)
        reader, writer, first_high, first_low, high, low, bits = fields
        words, _ = _read_words(data, at + 28, end, order, bits, 0)
        first, base = (first_high << 32) | first_low, (high << 32) | low
        if first < 1 or base < first:
            raise RtpsError(f'a GAP reaches from {first} to {base}')
        return cls(reader, writer, first, NumberSet(base, bits, words))

    def encode(self) -> bytes:
        """Return the submessage."""
        first, (base, bits, words) = self.first, self.irrelevant
        body = _GAP_HEAD[1].pack(
            self.reader,
            self.writer,
            first >> 32,
            first & 0xFFFFFFFF,
            base >> 32,
            base & 0xFFFFFFFF,
            bits,
        )
        return submessage(GAP, LITTLE, body + _WORDS[1][len(words)].pack(*words))


class NackFrag(NamedTuple):
    """NACK_FRAG: a reader requests fragments of one sample."""

    reader: bytes
    writer: bytes
    number: int
    missing: NumberSet
    counter: int

    @classmethod
    def read(cls, data: bytes, at: int, end: int, flags: int) -> NackFrag:
        """Read the body that stands from `at` to `end`."""
        order = flags & LITTLE
        reader, writer, high, low, base, bits = _NACK_FRAG_HEAD[order].unpack_from(data, at)
        words, at = _read_words(data, at + 24, end, order, bits)
        count = _COUNT[order].unpack_from(data, at)[0]
        return cls(reader, writer, (high << 32) | low, NumberSet(base, bits, words), count)

    def encode(self) -> bytes:
        """Return the submessage."""
        number, (base, bits, words) = self.number, self.missing
        body = _NACK_FRAG_HEAD[1].pack(
            self.reader, self.writer, number >> 32, number & 0xFFFFFFFF, base, bits
        )
        body += _WORDS[1][len(words)].pack(*words) + _COUNT[1].pack(self.counter)
        return submessage(NACK_FRAG, LITTLE, body)


class HeartbeatFrag(NamedTuple):
    """HEARTBEAT_FRAG: a writer has the fragments of a sample up to `last`."""

    reader: bytes
    writer: bytes
    number: int
    last: int
    counter: int

    @classmethod
    def read(cls, data: bytes, at: int, _end: int, flags: int) -> HeartbeatFrag:
        """Read the body that stands at `at`."""
        reader, writer, high, low, last, count = _HEARTBEAT_FRAG[flags & LITTLE].unpack_from(data, at)
        return cls(reader, writer, (high << 32) | low, last, count)

    def encode(self) -> bytes:
        """Return the submessage."""
        number = self.number
        body = _HEARTBEAT_FRAG[1].pack(
            self.reader, self.writer, number >> 32, number & 0xFFFFFFFF, self.last, self.counter
        )
        return submessage(HEARTBEAT_FRAG, LITTLE, body)


Body: TypeAlias = Data | DataFrag | Heartbeat | AckNack | Gap | NackFrag | HeartbeatFrag

_READERS: dict[int, tuple[int, Callable[[bytes, int, int, int], Body]]] = {
    DATA: (20, Data.read),
    DATA_FRAG: (32, DataFrag.read),
    HEARTBEAT: (28, Heartbeat.read),
    ACKNACK: (24, AckNack.read),
    GAP: (28, Gap.read),
    NACK_FRAG: (28, NackFrag.read),
    HEARTBEAT_FRAG: (24, HeartbeatFrag.read),
}
"""For each kind: the least size of a body, and the function that reads it."""


def read_body(kind: int, data: bytes, at: int, end: int, flags: int) -> Body | None:
    """Read a submessage's body; return None for a kind that this module has no record for.

    Raises RtpsError.
    """
    known = _READERS.get(kind)
    if known is None:
        return None
    least, read = known
    if end - at < least:
        raise RtpsError(f'a submessage 0x{kind:02x} has {end - at} bytes, and at least {least} are needed')
    return read(data, at, end, flags)


def submessage(kind: int, flags: int, body: bytes) -> bytes:
    """Return a submessage. If its body is too long for the length field, the field is 0: put it last."""
    size = len(body)
    if size & 3:
        body += bytes(-size & 3)
        size = len(body)
    return _HEAD.pack(kind, flags, size if size < 65536 else 0) + body


def header(prefix: bytes) -> bytes:
    """Return the header with which all packets of a participant begin."""
    return MAGIC + VERSION + VENDOR + prefix


def info_dst(prefix: bytes) -> bytes:
    """Return INFO_DST: the following submessages are for one participant."""
    return submessage(INFO_DST, LITTLE, prefix)


def info_ts(time: bytes) -> bytes:
    """Return INFO_TS: the source timestamp of the following submessages, encoded by `encode_time`."""
    return submessage(INFO_TS, LITTLE, time)


def check_header(packet: bytes) -> None:
    """Raise RtpsError if a packet is not one of RTPS 2."""
    if len(packet) < HEADER_SIZE or packet[:4] != MAGIC:
        raise RtpsError('a packet does not begin as RTPS does')
    if packet[4] != VERSION[0]:
        raise RtpsError(f'a packet is of RTPS {packet[4]}, and 2 is spoken here')


def split(packet: bytes) -> Iterator[tuple[int, int, int, int]]:
    """Yield each submessage's id, flags, and begin and end of its body; raises RtpsError if cut off."""
    at, size = HEADER_SIZE, len(packet)
    while at < size:
        if size - at < 4:
            raise RtpsError(f'a submessage is cut off at byte {at}')
        kind, flags = packet[at], packet[at + 1]
        low, high = (at + 2, at + 3) if flags & LITTLE else (at + 3, at + 2)
        length = packet[low] | packet[high] << 8
        at += 4
        # A length of 0 means that the body ends with the packet.
        if not length and kind not in (PAD, INFO_TS):
            length = size - at
        if length > size - at:
            raise RtpsError(f'a submessage 0x{kind:02x} of {length} bytes is cut off at byte {at}')
        yield kind, flags, at, at + length
        at += length


def skip_parameters(data: bytes | memoryview, at: int, end: int, order: int) -> int:
    """Return the offset behind the sentinel of the parameter list that begins at `at`; raises RtpsError."""
    two = TWO[order]
    for _ in range(bounds.MOST_PARAMETERS):
        if end - at < 4:
            break
        pid, size = two.unpack_from(data, at)
        at += 4
        if pid == SENTINEL:
            return at
        at += size
    raise RtpsError('a parameter list has no end')


SENTINEL = 0x0001
"""The parameter that ends a list (the sentinel)."""
TWO = [struct.Struct(f'{order}HH') for order in _ORDERS]


def _read_words(
    data: bytes, at: int, end: int, order: int, bits: int, after: int = 4
) -> tuple[tuple[int, ...], int]:
    """Return the words of a number set and the offset of their end.

    Raises RtpsError, also if less than `after` bytes follow.
    """
    count = (bits + 31) >> 5
    if bits > bounds.SET_BITS or at + 4 * count + after > end:
        raise RtpsError(f'a set has {bits} bits')
    return _WORDS[order][count].unpack_from(data, at), at + 4 * count
