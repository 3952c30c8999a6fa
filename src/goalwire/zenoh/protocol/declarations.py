"""DECLARE and INTEREST: each side declares its entities, and asks for the entities of the other.

Subscribers, queryables and liveliness tokens are declared under numbers. The declaring side chooses a number
and repeats it to take the declaration back. An expression is declared to give a long key a short number on
this link. A peer declares everything to each other peer without being asked, and then sends a final with
interest number 0. Routers and clients must be asked: an INTEREST names kinds of entities, maybe a key, and
asks for the present ones, for future changes, or for both. The declarations of the answer have the interest's
number, and a final ends them. Later changes have no number.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

from goalwire.records import record
from goalwire.zenoh.protocol.network import (
    DECLARE,
    INTEREST,
    IS_NAMED,
    IS_SENDERS,
    NODE_ID,
    QOS,
    WireKey,
    wire_key,
)
from goalwire.zenoh.protocol.primitives import (
    MORE,
    NUMBER_FORM,
    Reader,
    ZenohProtocolError,
    decode_text,
    encode_text,
    encode_z,
)

_QOS = bytes((QOS, 0x08))
"""Declarations have the highest priority and are never dropped."""
_HAS_INTEREST = 0x20
_FINAL = 0x1A
_INFO = NUMBER_FORM | 1
"""The extension of a queryable: whether it is complete (bit 0), and its distance (bits 8-23)."""
_TAKEN_BACK = 0x4F
"""The extension that may repeat the key in an undeclaration."""
_ITS_KEY_IS_EMPTY = b'\x5f\x02\0\0'
_COMMON = frozenset((QOS, NODE_ID, 0x42))


class Kind(IntEnum):
    """The kinds of declarations by their numbers on the wire. The undeclaration has the next number."""

    EXPRESSION = 0
    SUBSCRIBER = 2
    QUERYABLE = 4
    TOKEN = 6
    FINAL = _FINAL


@record
class Declaration:
    """One DECLARE. `interest` is the number of the INTEREST that it answers, None for a later change."""

    kind: Kind
    number: int = 0
    undeclares: bool = False
    scope: int = 0
    suffix: str = ''
    is_senders: bool = False
    complete: bool = False
    distance: int = 0
    interest: int | None = None


def declare_expression(number: int, key: str) -> bytes:
    """Return a DECLARE: `number` stands for `key` from now on."""
    return _head(None) + bytes((Kind.EXPRESSION | IS_NAMED,)) + encode_z(number) + b'\0' + encode_text(key)


def declare(
    kind: Kind, number: int, key: WireKey, *, complete: bool = False, interest: int | None = None
) -> bytes:
    """Return a DECLARE of a subscriber, queryable or token."""
    info = bytes((_INFO, 1)) if complete else b''
    header = kind | key.flags | (MORE if info else 0)
    return _head(interest) + bytes((header,)) + encode_z(number) + key.encoded + info


def take_back(kind: Kind, number: int) -> bytes:
    """Return an undeclaration. For queryables and tokens it has an empty key, as eclipse-zenoh's."""
    key = _ITS_KEY_IS_EMPTY if kind in {Kind.QUERYABLE, Kind.TOKEN} else b''
    return _head(None) + bytes((kind + 1 | (MORE if key else 0),)) + encode_z(number) + key


def final(interest: int = 0) -> bytes:
    """Return the end of the answer to an interest. 0 ends what a peer declares without being asked."""
    return _head(interest) + bytes((_FINAL,))


def _head(interest: int | None) -> bytes:
    if interest is None:
        return bytes((DECLARE | MORE,)) + _QOS
    return bytes((DECLARE | MORE | _HAS_INTEREST,)) + encode_z(interest) + _QOS


def read_declaration(reader: Reader) -> Declaration:
    """Read a DECLARE. Raises ZenohProtocolError."""
    header = reader.u8()
    interest = reader.z(32) if header & _HAS_INTEREST else None
    if header & MORE:
        reader.extensions(_COMMON)
    body = reader.u8()
    code = body & 0x1F
    if code == _FINAL:
        if body & MORE:
            reader.extensions()
        return Declaration(Kind.FINAL, interest=interest)
    if code > Kind.TOKEN + 1:
        raise ZenohProtocolError(f'there is no declaration with the id 0x{body:02x}')
    kind = Kind(code & ~1)
    number = reader.z(16 if kind is Kind.EXPRESSION else 32)
    if code & 1:
        if body & MORE:
            reader.extensions({_TAKEN_BACK})
        return Declaration(kind, number, undeclares=True, interest=interest)
    scope, suffix = _read_key(reader, body)
    found = reader.extensions({_INFO}) if body & MORE else {}
    info = found.get(_INFO, 0)
    assert isinstance(info, int)
    return Declaration(
        kind,
        number,
        scope=scope,
        suffix=suffix,
        is_senders=bool(body & IS_SENDERS) or kind is Kind.EXPRESSION,
        complete=bool(info & 1),
        distance=info >> 8 & 0xFFFF,
        interest=interest,
    )


def _read_key(reader: Reader, flags: int) -> tuple[int, str]:
    scope = reader.z(16)
    return scope, decode_text(reader.take_sized()) if flags & IS_NAMED else ''


class About(IntFlag):
    """The subject of an interest: subscribers, queryables or tokens, and a key."""

    EXPRESSIONS = 0x01
    SUBSCRIBERS = 0x02
    QUERYABLES = 0x04
    TOKENS = 0x08
    ALL = 0x0F


_HAS_KEY = 0x10


class When(IntFlag):
    """The entities that an interest asks for: present ones, future ones, or both; FINAL ends the interest."""

    FINAL = 0
    PRESENT = 1
    FUTURE = 2


@record
class Interest:
    """One INTEREST. Without `has_key`, it is about all entities of its kinds."""

    number: int
    when: When
    about: About = About(0)
    has_key: bool = False
    scope: int = 0
    suffix: str = ''
    is_senders: bool = False


def interest(number: int, when: When, about: int = 0, key: str | None = None) -> bytes:
    """Return an INTEREST. It names a key in full."""
    out = bytes((INTEREST | when << 5 | MORE,)) + encode_z(number)
    if when:
        options = about
        named = b''
        if key is not None:
            full = wire_key(key)
            options |= _HAS_KEY | full.flags
            named = full.encoded
        out += bytes((options,)) + named
    return out + _QOS


def read_interest(reader: Reader) -> Interest:
    """Read an INTEREST. Raises ZenohProtocolError."""
    header = reader.u8()
    number = reader.z(32)
    when = When(header >> 5 & 3)
    about, scope, suffix, options = About(0), 0, '', 0
    if when:
        options = reader.u8()
        about = About(options & About.ALL)
        if options & _HAS_KEY:
            scope, suffix = _read_key(reader, options)
    if header & MORE:
        reader.extensions(_COMMON)
    return Interest(number, when, about, bool(options & _HAS_KEY), scope, suffix, bool(options & IS_SENDERS))
