"""The 16 bytes before every request and reply: whose it is, and its number.

uint64 client (the instance handle of its request writer), int64 sequence, in the encapsulation's byte order.
Source: rmw_cyclonedds_cpp src/serdata.hpp (cdds_request_header_t), src/Serialization.cpp.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from struct import Struct
from typing import NamedTuple

from goalwire.errors import RemoteError

ENCAPSULATION_SIZE = 4
SIZE = 16

_LITTLE = Struct('<Qq')
_BIG = Struct('>Qq')


class Header(NamedTuple):
    """What a reply must repeat."""

    client: int
    sequence: int


_header: Callable[[tuple[int, int]], Header] = partial(tuple.__new__, Header)
"""Makes one as its class does, without a call of Python code."""


def wrap(header: tuple[int, int], message: bytes) -> bytes:
    """Return a message, encapsulation first, with the header put in."""
    layout = _LITTLE if message[1] & 1 else _BIG
    return message[:ENCAPSULATION_SIZE] + layout.pack(*header) + message[ENCAPSULATION_SIZE:]


def unwrap(payload: bytes) -> tuple[Header, bytes]:
    """Return the header and the message without it; raises RemoteError where there is none."""
    start = ENCAPSULATION_SIZE + SIZE
    if len(payload) <= start:
        raise RemoteError(f'{len(payload)} bytes are too few for a service header and a message')
    layout = _LITTLE if payload[1] & 1 else _BIG
    header = _header(layout.unpack_from(payload, ENCAPSULATION_SIZE))
    return header, payload[:ENCAPSULATION_SIZE] + payload[start:]
