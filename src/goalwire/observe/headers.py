"""Reads the stamp of a message whose type is unknown: by convention the header is a message's first field."""

from __future__ import annotations

import struct

_HEAD = 4
"""The number of bytes before the first field. The lowest bit of the second byte is set for little endian."""


def stamp_of_first_field(data: bytes) -> float | None:
    """Return the stamp of a serialized message in s; None if its first field cannot be a std_msgs/Header.

    In CDR a header is a time (two numbers of 32 bits) and a text (its length, its bytes, a 0).
    """
    if len(data) < _HEAD + 13:
        return None
    order = '<' if data[1] & 1 else '>'
    seconds, nanoseconds, length = struct.unpack_from(f'{order}iII', data, _HEAD)
    end = _HEAD + 12 + length
    if nanoseconds >= 10**9 or not length or end > len(data) or data[end - 1]:
        return None
    return float(seconds + nanoseconds / 1e9)
