"""The stamp of a message whose type is unknown: by convention a header is the first field."""

from __future__ import annotations

import struct

_HEAD = 4
"""Bytes before the first field; the lowest bit of the second one says that numbers are in little endian."""


def stamp_of_first_field(data: bytes) -> float | None:
    """Return the stamp of a serialized message in s; None if its first field cannot be a std_msgs/Header.

    A header is a time, which is two numbers of 32 bits, and a text: its length, then its bytes, then a 0.
    """
    if len(data) < _HEAD + 13:
        return None
    order = '<' if data[1] & 1 else '>'
    seconds, nanoseconds, length = struct.unpack_from(f'{order}iII', data, _HEAD)
    end = _HEAD + 12 + length
    if nanoseconds >= 10**9 or not length or end > len(data) or data[end - 1]:
        return None
    return float(seconds + nanoseconds / 1e9)
