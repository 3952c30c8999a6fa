"""Numbers, texts, ids, extensions, timestamps and encodings: the parts of every message.

A number ("z") has groups of seven bits, the least significant first; every byte but the last has its top bit
set. It has nine bytes at most, and the ninth carries eight bits, so that 64 fit. A number may be padded with
bytes that add nothing (`86 80 80 00` is 6); sequence numbers are written so, always in four bytes.

A text or a piece of data is its length, a number, and its bytes. Extensions follow the part that they extend,
as a list: each begins with a byte of an id (bits 0-3), "must be known" (0x10), a form (0x60) and "more
follow" (0x80). The form is one of: nothing, a number (0x20), data (0x40). Equal ids with different forms are
different extensions. So both together identify an extension here, as in `header & EXTENSION`.
"""

from __future__ import annotations

from collections.abc import Container
from typing import NamedTuple

from goalwire.errors import RemoteError

VERSION = 9
MORE = 0x80
"""In an extension's first byte: another extension follows. In a message's first byte: extensions follow."""
MANDATORY = 0x10
FORM = 0x60
NUMBER_FORM = 0x20
DATA_FORM = 0x40
EXTENSION = 0x6F
"""The bits that identify an extension: its id and its form."""

MAX_ID = 16
"""Bytes of a Zenoh id at most."""

SMALL_END = 2048
"""Numbers below this are in SMALL_Z."""

GENERIC, UNSUPPORTED, INVALID, MAX_SESSIONS, MAX_LINKS, EXPIRED, UNRESPONSIVE, TO_SELF = range(8)
"""The reasons for closing a link, by their numbers in CLOSE."""


class ZenohProtocolError(RemoteError):
    """The other side of a link broke Zenoh's protocol. The link is closed with `reason`."""

    def __init__(self, message: str, reason: int = INVALID) -> None:
        super().__init__(message)
        self.reason = reason


def unknown_extension(header: int) -> ZenohProtocolError:
    """Return the error for an unknown mandatory extension with this first byte."""
    return ZenohProtocolError(
        f'extension 0x{header:02x} is unknown, and the message says that it must be known', UNSUPPORTED
    )


def _long_z(number: int) -> bytes:
    """Encode by the grammar: seven bits in each byte, and eight bits in the ninth."""
    out = bytearray()
    while number > 0x7F and len(out) < 8:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)
    return bytes(out)


LAST = [bytes((group,)) for group in range(0x80)]
"""The encodings of a number's last group of seven bits."""
FOLLOWED = [bytes((group | 0x80,)) for group in range(0x80)]
"""The encodings of a group of seven bits that others follow."""
SMALL_Z = LAST + [low + high for high in LAST[1 : SMALL_END >> 7] for low in FOLLOWED]
"""The encodings of the numbers below SMALL_END, for hot paths that save the call of `encode_z`."""


def encode_z(number: int) -> bytes:
    """Return a number of up to 64 bits in as few bytes as it needs."""
    if number < SMALL_END:
        return SMALL_Z[number]
    if number < 1 << 21:
        last = FOLLOWED[number >> 7 & 0x7F] + LAST[number >> 14] if number >> 14 else LAST[number >> 7]
        return FOLLOWED[number & 0x7F] + last
    return _long_z(number)


def encode_padded(number: int) -> bytes:
    """Return a number below 2^28 in four bytes."""
    low, high = number & 0x3FFF, number >> 14
    return b'%b%b%b%b' % (FOLLOWED[low & 0x7F], FOLLOWED[low >> 7], FOLLOWED[high & 0x7F], LAST[high >> 7])


def encode_data(data: bytes) -> bytes:
    """Return data with their length before them."""
    return encode_z(len(data)) + data


def encode_text(text: str) -> bytes:
    """Return a text with its length in bytes before it."""
    return encode_data(text.encode())


def decode_z(data: bytes, at: int) -> tuple[int, int]:
    """Return the number at `at` and the position after it. Raises IndexError if the data end first."""
    byte = data[at]
    at += 1
    if byte < 0x80:
        return byte, at
    number = byte & 0x7F
    for shift in (7, 14, 21, 28, 35, 42, 49):
        byte = data[at]
        at += 1
        if byte < 0x80:
            return number | byte << shift, at
        number |= (byte & 0x7F) << shift
    return number | data[at] << 56, at + 1


class Reader:
    """Takes one message apart, from `at` up to `end`; raises ZenohProtocolError if it is cut off."""

    __slots__ = ('at', 'data', 'end')

    def __init__(self, data: bytes, at: int = 0, end: int | None = None) -> None:
        self.data = data
        self.at = at
        self.end = len(data) if end is None else end

    def u8(self) -> int:
        """Take a byte."""
        at = self.at
        if at >= self.end:
            raise ZenohProtocolError(f'a message is cut off at byte {at}')
        self.at = at + 1
        return self.data[at]

    def z(self, bits: int = 64) -> int:
        """Take a number that must fit `bits`."""
        try:
            number, at = decode_z(self.data, self.at)
        except IndexError:
            at, number = self.end + 1, 0
        if at > self.end:
            raise ZenohProtocolError(f'a number is cut off at byte {self.at}')
        if number >> bits:
            raise ZenohProtocolError(f'number {number} at byte {self.at} does not fit {bits} bits')
        self.at = at
        return number

    def take(self, size: int) -> bytes:
        """Take `size` bytes."""
        at = self.at
        if size > self.end - at:
            raise ZenohProtocolError(f'{size} bytes announced at byte {at}, {self.end - at} are left')
        self.at = at + size
        return self.data[at : self.at]

    def take_sized(self) -> bytes:
        """Take data with their length before them."""
        return self.take(self.z(32))

    def text(self) -> str:
        """Take a text."""
        return decode_text(self.take_sized())

    def zid(self, size: int | None = None) -> bytes:
        """Take a Zenoh id of `size` bytes; without `size`, its length stands before it."""
        size = self.z(8) if size is None else size
        if not 0 < size <= MAX_ID:
            raise ZenohProtocolError(f'a Zenoh id has 1 to {MAX_ID} bytes, not {size}')
        return self.take(size)

    def extensions(self, known: Container[int] = ()) -> dict[int, int | bytes]:
        """Take a list of extensions, by id and form. Raises ZenohProtocolError for unknown mandatory ones."""
        found: dict[int, int | bytes] = {}
        header = MORE
        while header & MORE:
            header = self.u8()
            form = header & FORM
            value: int | bytes = 0
            if form == NUMBER_FORM:
                value = self.z()
            elif form == DATA_FORM:
                value = self.take_sized()
            elif form:
                raise ZenohProtocolError(f'extension 0x{header:02x} has a form that does not exist')
            if header & EXTENSION in known:
                found[header & EXTENSION] = value
            elif header & MANDATORY:
                raise unknown_extension(header)
        return found


def decode_text(data: bytes) -> str:
    """Return a text; raises ZenohProtocolError if it is not UTF-8."""
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise ZenohProtocolError(f'a text is not UTF-8: {error}') from None


def show_id(zid: bytes) -> str:
    """Return an id as users and keys show it: as a hexadecimal number whose lowest byte comes first."""
    return zid[::-1].hex().lstrip('0') or '0'


def read_id(text: str) -> bytes:
    """Return the encoded form of an id that is shown as `text`."""
    return bytes.fromhex(text.rjust(len(text) + len(text) % 2, '0'))[::-1]


class Timestamp(NamedTuple):
    """The time of a message, by the clock of `zid`; `time` is in units of 2^-32 s since 1970."""

    time: int
    zid: bytes


def encode_timestamp(time: int, zid: bytes) -> bytes:
    """Return a timestamp; `time` has 64 bits, and is written in nine bytes."""
    groups = b''.join([FOLLOWED[time >> shift & 0x7F] for shift in range(0, 56, 7)])
    return b'%b%c%c%b' % (groups, time >> 56, len(zid), zid)


def decode_timestamp(data: bytes) -> Timestamp:
    """Read a timestamp."""
    reader = Reader(data)
    return Timestamp(reader.z(), reader.zid())


def ntp64(ns: int) -> int:
    """Convert nanoseconds since 1970 to a timestamp's units of 2^-32 s."""
    seconds, rest = divmod(ns, 1_000_000_000)
    return seconds << 32 | (rest << 32) // 1_000_000_000


class SourceInfo(NamedTuple):
    """The publisher of a message, an entity of the session `zid`, and the message's number there."""

    zid: bytes
    entity: int
    number: int


def encode_source(source: SourceInfo) -> bytes:
    """Return a source without its length."""
    return encode_replier(source.zid, source.entity) + encode_z(source.number)


def encode_replier(zid: bytes, entity: int) -> bytes:
    """Return the id of the replier, without the length."""
    return encode_session(zid) + encode_z(entity)


def encode_session(zid: bytes) -> bytes:
    """Return the first bytes of all sources and repliers of a session."""
    return bytes(((len(zid) - 1) << 4,)) + zid


def decode_source(data: bytes) -> SourceInfo:
    """Read a source; raises ZenohProtocolError."""
    reader = Reader(data)
    zid = reader.zid((reader.u8() >> 4) + 1)
    return SourceInfo(zid, reader.z(32), reader.z(32))
