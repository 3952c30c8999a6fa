"""PUT, DEL and QUERY: the bodies of the messages in network.py, which hold what users send and ask.

Most of the traffic consists of these bodies. So they are read by plain indexing: reading beyond the data
raises IndexError, and each function checks at its end that it has not read beyond its body.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, TypeAlias

from goalwire.zenoh.protocol.primitives import (
    DATA_FORM,
    EXTENSION,
    FORM,
    MANDATORY,
    MORE,
    NUMBER_FORM,
    SMALL_END,
    SMALL_Z,
    SourceInfo,
    Timestamp,
    ZenohProtocolError,
    decode_source,
    decode_timestamp,
    decode_z,
    encode_data,
    encode_z,
    unknown_extension,
)
from goalwire.zenoh.protocol.shared_memory import MARK_OF_PUT, MARK_OF_QUERY, Slices, read_slices

PUT, DEL, QUERY = range(1, 4)
MESSAGE_ID = 0x1F

HAS_STAMP = 0x20
HAS_ENCODING = 0x40
SOURCE = 0x41
ATTACHMENT_OF_PUT = 0x43
ATTACHMENT_OF_DEL = 0x42
BODY_OF_QUERY = 0x43
ATTACHMENT_OF_QUERY = 0x45
HAS_CONSOLIDATION = 0x20
HAS_PARAMETERS = 0x40

_UNIT = EXTENSION | MANDATORY
"""The bits that identify an extension which has no body."""

LARGE = 65536
"""Payloads of this many bytes or more are views of the received data; smaller ones are copied."""

Payload: TypeAlias = bytes | memoryview
Resolve: TypeAlias = Callable[[Slices], Payload | None]
"""Joins slices, some in shared memory, to a payload; returns None if the sender has reused the memory."""


def refuse_slices(_slices: Slices) -> None:
    """Refuse slices, as the `Resolve` of links without shared memory. Raises ZenohProtocolError."""
    raise unknown_extension(MARK_OF_PUT)


class Sample(NamedTuple):
    """A received message, reply or change of a token. Its stamp and source are still encoded."""

    key: str
    payload: Payload | None
    """None if the key was deleted."""
    attachment: bytes | None = None
    stamp: bytes | None = None
    source: bytes | None = None

    @property
    def timestamp(self) -> Timestamp | None:
        """The timestamp of the message; None if it has none. Raises ZenohProtocolError."""
        return None if self.stamp is None else decode_timestamp(self.stamp)

    @property
    def source_info(self) -> SourceInfo | None:
        """The publisher, if the message names it. Raises ZenohProtocolError."""
        return None if self.source is None else decode_source(self.source)


SampleFields: TypeAlias = tuple[str, Payload | None, bytes | None, bytes | None, bytes | None]
new_sample: Callable[[SampleFields], Sample] = partial(tuple.__new__, Sample)
"""Makes a Sample faster than the class itself, without running Python code: each message needs one."""


# ---- PUT and DEL, in a PUSH or a REPLY

PUT_OF_ROS = PUT | HAS_STAMP | MORE
"""The header of a PUT with a stamp and an attachment."""
_PUT_OF_ROS = bytes((PUT_OF_ROS,))
_ATTACHMENT = bytes((ATTACHMENT_OF_PUT,))


def put_body(
    payload: Payload,
    attachment: bytes | None = None,
    stamp: bytes | None = None,
    source: bytes | None = None,
) -> bytes:
    """Return an encoded PUT; `stamp` and `source` are encoded already."""
    size = len(payload)
    if source is None and stamp is not None and attachment is not None and size < SMALL_END:
        # hot path of all messages that ROS publishes: takes 0.3 µs instead of 1.0 for put_head and its calls
        length, about = SMALL_Z[size], SMALL_Z[len(attachment)]
        return b''.join((_PUT_OF_ROS, stamp, _ATTACHMENT, about, attachment, length, payload))
    return b''.join((put_head(size, attachment, stamp, source), payload))


def put_head(
    size: int,
    attachment: bytes | None = None,
    stamp: bytes | None = None,
    source: bytes | None = None,
) -> bytes:
    """Return a PUT up to its payload, which has `size` bytes."""
    header = PUT if stamp is None else PUT | HAS_STAMP
    extensions = b''
    if source is not None:
        extensions = bytes((SOURCE | (MORE if attachment is not None else 0),)) + encode_data(source)
    if attachment is not None:
        extensions += bytes((ATTACHMENT_OF_PUT,)) + encode_data(attachment)
    if extensions:
        header |= MORE
    return b'%c%b%b%b' % (header, stamp or b'', extensions, encode_z(size))


def del_body(
    attachment: bytes | None = None, stamp: bytes | None = None, source: bytes | None = None
) -> bytes:
    """Return the body of a DEL."""
    header = DEL if stamp is None else DEL | HAS_STAMP
    extensions = b''
    if source is not None:
        extensions = bytes((SOURCE | (MORE if attachment is not None else 0),)) + encode_data(source)
    if attachment is not None:
        extensions += bytes((ATTACHMENT_OF_DEL,)) + encode_data(attachment)
    return bytes((header | (MORE if extensions else 0),)) + (stamp or b'') + extensions


def shared_put_head(attachment: bytes | None, stamp: bytes | None, source: bytes | None) -> bytes:
    """Return a PUT up to the slices that stand in place of its payload."""
    header = PUT | MORE if stamp is None else PUT | MORE | HAS_STAMP
    extensions = b'' if source is None else bytes((SOURCE | MORE,)) + encode_data(source)
    if attachment is None:
        extensions += bytes((MARK_OF_PUT,))
    else:
        extensions += bytes((MARK_OF_PUT | MORE, ATTACHMENT_OF_PUT)) + encode_data(attachment)
    return b'%c%b%b' % (header, stamp or b'', extensions)


def read_body(
    data: bytes, at: int, end: int, key: str, resolve: Resolve = refuse_slices
) -> tuple[Sample | None, int]:
    """Read a PUT or DEL on `key`; return its sample and the position after it.

    The sample is None if its payload was in shared memory that the sender has reused.
    """
    header = data[at]
    kind = header & MESSAGE_ID
    at += 1
    stamp = source = attachment = None
    is_shared = False
    if header & HAS_STAMP:
        start = at
        _, at = decode_z(data, at)
        at += 1 + data[at]
        stamp = data[start:at]
    if kind == PUT:
        if header & HAS_ENCODING:
            at = skip_encoding(data, at)
    elif kind != DEL:
        raise ZenohProtocolError(f'0x{header:02x} is neither PUT nor DEL')
    attachment_id = ATTACHMENT_OF_PUT if kind == PUT else ATTACHMENT_OF_DEL
    while header & MORE:
        header = data[at]
        at += 1
        if header & FORM == DATA_FORM:
            size = data[at]
            at += 1
            if size > 0x7F:
                size, at = decode_z(data, at - 1)
            which = header & EXTENSION
            if which == attachment_id:
                attachment = data[at : at + size]
            elif which == SOURCE:
                source = data[at : at + size]
            elif header & MANDATORY:
                raise unknown_extension(header)
            at += size
        elif header & _UNIT == MARK_OF_PUT and kind == PUT:
            is_shared = True
        else:
            at = _skip_extension(data, at, header)
    payload: Payload | None = None
    if is_shared:
        slices, at = read_slices(data, at, end)
        payload = resolve(slices)
        if payload is None:
            return None, at
    elif kind == PUT:
        size = data[at]
        at += 1
        if size > 0x7F:
            size, at = decode_z(data, at - 1)
        payload = data[at : at + size] if size < LARGE else memoryview(data)[at : at + size]
        at += size
    if at > end:
        raise ZenohProtocolError('a PUT or DEL is cut off')
    return new_sample((key, payload, attachment, stamp, source)), at


def _skip_extension(data: bytes, at: int, header: int) -> int:
    """Return the position after an extension without data, which this library does not know."""
    form = header & FORM
    if form == FORM or header & MANDATORY:
        raise unknown_extension(header)
    return decode_z(data, at)[1] if form == NUMBER_FORM else at


def skip_encoding(data: bytes, at: int) -> int:
    """Return the position after an encoding."""
    number, at = decode_z(data, at)
    if number & 1:
        size, at = decode_z(data, at)
        at += size
    return at


# ---- QUERY, in a REQUEST


class Consolidation:
    """The ways to treat several replies of one key, by their numbers in a QUERY."""

    AUTO = 0
    NONE = 1
    MONOTONIC = 2
    LATEST = 3


class QueryMessage(NamedTuple):
    """A received QUERY."""

    parameters: str
    payload: Payload | None
    attachment: bytes | None
    source: bytes | None


def query_head(consolidation: int, parameters: str, *, has_payload: bool, has_attachment: bool) -> bytes:
    """Return a QUERY up to its payload's length; if it has no payload, up to its attachment."""
    header = QUERY | HAS_CONSOLIDATION
    out = encode_z(consolidation)
    if parameters:
        header |= HAS_PARAMETERS
        out += encode_data(parameters.encode())
    if has_payload or has_attachment:
        header |= MORE
    if has_payload:
        out += bytes((BODY_OF_QUERY | (MORE if has_attachment else 0),))
    return bytes((header,)) + out


def query_rest(payload: Payload | None, attachment: bytes | None) -> bytes:
    """Return the part of a query after `query_head`."""
    if payload is None:
        return b'' if attachment is None else _ATTACHMENT_OF_QUERY + encode_data(attachment)
    size = len(payload) + 1
    length = SMALL_Z[size] if size < SMALL_END else encode_z(size)
    if attachment is None:
        return b''.join((length, b'\0', payload))
    about = encode_z(len(attachment))
    return b''.join((length, b'\0', payload, _ATTACHMENT_OF_QUERY, about, attachment))


_ATTACHMENT_OF_QUERY = bytes((ATTACHMENT_OF_QUERY,))


def read_query(
    data: bytes, at: int, end: int, resolve: Resolve = refuse_slices
) -> tuple[QueryMessage | None, int]:
    """Return a QUERY and the position after it. The QUERY is None if its payload in shared memory is lost."""
    header = data[at]
    at += 1
    if header & MESSAGE_ID != QUERY:
        raise ZenohProtocolError(f'0x{header:02x} is not a QUERY')
    if header & HAS_CONSOLIDATION:
        _, at = decode_z(data, at)
    parameters = ''
    if header & HAS_PARAMETERS:
        size, at = decode_z(data, at)
        parameters = data[at : at + size].decode()
        at += size
    payload: Payload | None = None
    attachment = source = None
    is_shared = is_lost = False
    while header & MORE:
        header = data[at]
        at += 1
        if header & FORM == DATA_FORM:
            size = data[at]
            at += 1
            if size > 0x7F:
                size, at = decode_z(data, at - 1)
            which = header & EXTENSION
            if which == BODY_OF_QUERY and is_shared:
                slices, at = read_slices(data, skip_encoding(data, at), end)
                payload = resolve(slices)
                is_lost = payload is None
                size = 0
            elif which == BODY_OF_QUERY:
                start = at + 1 if data[at] == 0 else skip_encoding(data, at)
                payload = data[start : at + size] if size < LARGE else memoryview(data)[start : at + size]
            elif which == ATTACHMENT_OF_QUERY:
                attachment = data[at : at + size]
            elif which == SOURCE:
                source = data[at : at + size]
            elif header & MANDATORY:
                raise unknown_extension(header)
            at += size
        elif header & _UNIT == MARK_OF_QUERY:
            is_shared = True
        else:
            at = _skip_extension(data, at, header)
    if at > end:
        raise ZenohProtocolError('a QUERY is cut off')
    if is_lost:
        return None, at
    return QueryMessage(parameters, payload, attachment, source), at
