"""The attachment of every message: sequence number, source time and the sender's gid.

33 bytes: int64 LE sequence, int64 LE nanoseconds since the UNIX epoch, 0x10 (the gid's length), the gid.
Older peers (humble up to 0.1.1, jazzy up to 0.2.3) name each field and need 77 bytes; those are read too.
Source: rmw_zenoh_cpp src/detail/attachment_helpers.cpp.

A payload and its attachment become the Sample that entities receive.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from time import time_ns
from typing import TypeAlias

from goalwire.errors import RemoteError
from goalwire.transport.contract import Sample, new_sample
from goalwire.transport.zenoh.wire import Message
from goalwire.zenoh.protocol.incoming_queries import Query

GID_SIZE = 16
SIZE = 33
NAMED_SIZE = 77

Attachment: TypeAlias = tuple[int, int, bytes]
"""The fields of an attachment: sequence number, source timestamp in ns, gid."""

_PLAIN = Struct('<qqB16s')
_NAMED = Struct('<16sq17sq12s16s')
_NAMES = (b'\x0fsequence_number', b'\x10source_timestamp', b'\x0asource_gid\x10')


encode: Callable[[int, int, int, bytes], bytes] = _PLAIN.pack
"""Makes the 33 bytes from a sequence number, a time in ns, GID_SIZE and a gid, without Python code."""

split: Callable[[bytes], tuple[int, int, int, bytes]] = _PLAIN.unpack
"""Splits 33 bytes into the four fields without checks and without Python code."""


def decode(data: bytes) -> Attachment:
    """Read an attachment of either form; raises RemoteError for anything else."""
    if len(data) == SIZE:
        sequence, timestamp, size, gid = split(data)
        if size != GID_SIZE:
            raise RemoteError(f'attachment: byte 16 says the gid has {size} bytes, not {GID_SIZE}')
    elif len(data) == NAMED_SIZE:
        name1, sequence, name2, timestamp, name3, gid = _NAMED.unpack(data)
        if (name1, name2, name3) != _NAMES:
            raise RemoteError('attachment: it has the 77 bytes of the older form, but not its field names')
    else:
        raise RemoteError(
            f'attachment: {len(data)} bytes, expected {SIZE}, or {NAMED_SIZE} in the older form'
        )
    if sequence < 0 or timestamp < 0:
        raise RemoteError(f'attachment: negative sequence {sequence} or timestamp {timestamp}')
    return sequence, timestamp, gid


def sample_of(carrier: Message | Query) -> Sample:
    """Return a received message as a Sample; raises RemoteError if its attachment breaks the rules.

    Most received messages pass here, on the thread that reads. So the ordinary attachment is read in place,
    which saves three calls.
    """
    received = time_ns()
    data, payload = carrier.attachment, carrier.payload
    if data is None:
        raise RemoteError('attachment: there is none')
    size = 0
    if len(data) == SIZE:
        sequence, sent, size, gid = split(data)
    if size != GID_SIZE or sequence < 0 or sent < 0:
        sequence, sent, gid = decode(data)
    if payload is None:
        raise RemoteError(f'request {sequence} has no payload')
    return new_sample((payload, sequence, sent, received, gid))
