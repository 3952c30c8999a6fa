"""Reads the packets in which nearly all samples come: a header, INFO_TS, and a whole sample or fragments.

INFO_DST may come before INFO_TS, and one vendor-specific submessage at the end, as Fast DDS sends it. Any
other packet is left to `receiver.py`, which reads it submessage by submessage.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import partial

from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.messages import (
    DATA,
    DATA_FRAG,
    HEADER_SIZE,
    INFO_DST,
    INFO_TS,
    INLINE_QOS,
    LITTLE,
    WITH_DATA,
    DataFrag,
    skip_parameters,
)
from goalwire.rtps.protocol.parameters import HEADS_OF_RELATED_SAMPLE, RELATED_SAMPLE_ALONE
from goalwire.rtps.protocol.primitives import NS, PREFIX_SIZE

_HEADS = struct.Struct('<BBHIIBBHHH4s4siI')
"""INFO_TS, and DATA up to its inline QoS or payload."""
_FRAGMENT_HEADS = struct.Struct('<BBHIIBBHHH4s4siIIHHI')
"""INFO_TS, and DATA_FRAG up to its inline QoS or payload."""
_DATA_BODY = 16
"""The offset of the body of DATA or DATA_FRAG from the beginning of INFO_TS."""
_INFO_DST_HEAD = bytes((INFO_DST, LITTLE, PREFIX_SIZE, 0))
_VENDORS = 0x80
"""Submessages with this id or a higher one are vendor-specific."""
_new_sample: Callable[[tuple[bytes, int, int | None, bytes | None, bytes, bool]], Sample] = partial(
    tuple.__new__, Sample
)
"""Makes a Sample in C code, which is faster than a call of the class."""


def read_plain(packet: bytes, prefix: bytes, own_prefix: bytes) -> tuple[bytes, Sample] | None:
    """Return the reader's entity id and the sample of a plain packet; None for any other packet.

    A packet for another participant gives None, too. `prefix` is the sender's GUID prefix. Raises RtpsError.
    """
    at, size = HEADER_SIZE, len(packet)
    if packet.startswith(_INFO_DST_HEAD, HEADER_SIZE):
        at += len(_INFO_DST_HEAD) + PREFIX_SIZE
        if packet[at - PREFIX_SIZE : at] != own_prefix:
            return None
    if size - at < _HEADS.size:
        return None
    heads = _HEADS.unpack_from(packet, at)
    info, info_flags, info_size, seconds, fraction, data, flags, length = heads[:8]
    before, reader, writer, high, low = heads[9:]
    end = at + _DATA_BODY + length
    at += _HEADS.size
    has_qos = flags & INLINE_QOS
    if (info, info_flags, info_size, data, before) != (INFO_TS, LITTLE, 8, DATA, 16):
        return None
    if flags - has_qos != LITTLE | WITH_DATA or high < 0 or not at <= end <= size or not low | high:
        return None
    if end < size and not (size - end >= 4 and packet[end] >= _VENDORS and _is_last(packet, end, size)):
        return None
    qos = b''
    if has_qos:
        # hot path: one comparison recognizes the inline QoS of requests and replies, which saves a call
        qos_end = at + RELATED_SAMPLE_ALONE.size
        if qos_end > end or RELATED_SAMPLE_ALONE.unpack_from(packet, at) != HEADS_OF_RELATED_SAMPLE:
            qos_end = skip_parameters(packet, at, end, LITTLE)
        qos = packet[at:qos_end]
        at = qos_end
    if at > end:
        return None
    time = seconds * NS + (fraction * NS >> 32)
    return reader, _new_sample((prefix + writer, high << 32 | low, time, packet[at:end], qos, False))


def read_plain_fragments(packet: memoryview, own_prefix: bytes) -> tuple[DataFrag, int] | None:
    """Return the fragments in a plain packet that is not for another participant, and their source timestamp.

    The payload of the fragments is a part of the packet, and not a copy. Raises RtpsError.
    """
    at, size = HEADER_SIZE, len(packet)
    if packet[at : at + len(_INFO_DST_HEAD)] == _INFO_DST_HEAD:
        at += len(_INFO_DST_HEAD) + PREFIX_SIZE
        if packet[at - PREFIX_SIZE : at] != own_prefix:
            return None
    if size - at < _FRAGMENT_HEADS.size:
        return None
    heads = _FRAGMENT_HEADS.unpack_from(packet, at)
    info, info_flags, info_size, seconds, fraction, data, flags, length = heads[:8]
    before, reader, writer, high, low, first, count, fragment_size, sample_size = heads[9:]
    end = at + _DATA_BODY + length if length else size
    at += _FRAGMENT_HEADS.size
    has_qos = flags & INLINE_QOS
    if (info, info_flags, info_size, data, before) != (INFO_TS, LITTLE, 8, DATA_FRAG, 28):
        return None
    if flags - has_qos != LITTLE or high < 0 or not at <= end <= size or not low | high:
        return None
    if end < size and not (size - end >= 4 and packet[end] >= _VENDORS and _is_last(packet, end, size)):
        return None
    qos = b''
    if has_qos:
        qos_end = skip_parameters(packet, at, end, LITTLE)
        qos = bytes(packet[at:qos_end])
        at = qos_end
    if at > end:
        return None
    number, payload = high << 32 | low, packet[at:end]
    fragments = DataFrag(reader, writer, number, first, count, fragment_size, sample_size, qos, payload)
    return fragments, seconds * NS + (fraction * NS >> 32)


def _is_last(packet: bytes | memoryview, at: int, size: int) -> bool:
    """Return True if the submessage at `at` is the last one of a packet of `size` bytes."""
    length = packet[at + 2 : at + 4]
    return at + 4 + int.from_bytes(length, 'little' if packet[at + 1] & LITTLE else 'big') == size
