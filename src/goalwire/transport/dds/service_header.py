"""The header of requests and replies, and the refusals that goalwire's servers send.

Before every request and reply stand 16 bytes, in the encapsulation's byte order: uint64 client (the instance
handle of its request writer) and int64 sequence number. Source: rmw_cyclonedds_cpp src/serdata.hpp
(cdds_request_header_t), src/Serialization.cpp.

A refusal tells a client that its request will not be answered. rmw_cyclonedds has no message for that, so a
refusal looks to stock ROS 2 like a reply to another client. It is sent only to clients that say in their
USER_DATA that they know it (`goalwire=1`; other readers of USER_DATA skip unknown keys). Every client of the
service receives it, as all replies. Clients of stock ROS 2 drop it, since it has another client's id. But
they decode it first. So it begins with zeros, which are a valid message of every type; the reason comes after
them. Its sequence number is the request's, negated.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from struct import Struct
from typing import NamedTuple

from goalwire.errors import RemoteError, peer_text

ENCAPSULATION_SIZE = 4
SIZE = 16

_LITTLE = Struct('<Qq')
_BIG = Struct('>Qq')


class Header(NamedTuple):
    """The header of a request, which its reply repeats."""

    client: int
    sequence: int


_new_header: Callable[[tuple[int, int]], Header] = partial(tuple.__new__, Header)
"""Makes a Header by tuple.__new__, which runs no Python code."""


def wrap(header: tuple[int, int], message: bytes) -> bytes:
    """Return a message, encapsulation first, with the header put in."""
    layout = _LITTLE if message[1] & 1 else _BIG
    return message[:ENCAPSULATION_SIZE] + layout.pack(*header) + message[ENCAPSULATION_SIZE:]


def unwrap(payload: bytes) -> tuple[Header, bytes]:
    """Return the header and the message without it; raises RemoteError if there is none."""
    start = ENCAPSULATION_SIZE + SIZE
    if len(payload) <= start:
        raise RemoteError(f'{len(payload)} bytes are too few for a service header and a message')
    layout = _LITTLE if payload[1] & 1 else _BIG
    header = _new_header(layout.unpack_from(payload, ENCAPSULATION_SIZE))
    return header, payload[:ENCAPSULATION_SIZE] + payload[start:]


_ZEROS = bytes(1024)
_ENCAPSULATION = b'\0\1\0\0'
_REASON_SIZE = Struct('<I')
_LONGEST = 1000


def refusal(header: Header, reason: str) -> bytes:
    """Return the whole reply that refuses a request: header, zeros, the reason, the reason's length."""
    text = reason.encode()[:_LONGEST]
    padded = text.ljust(-(-len(text) // 4) * 4, b'\0')
    message = b''.join((_ENCAPSULATION, _ZEROS, padded, _REASON_SIZE.pack(len(text))))
    return wrap(Header(header.client, -header.sequence), message)


def refusal_reason(message: bytes) -> str:
    """Return the reason in a refusal without its header; '' if it is unreadable."""
    end = len(message) - _REASON_SIZE.size
    if end < ENCAPSULATION_SIZE:
        return ''
    (size,) = _REASON_SIZE.unpack_from(message, end)
    start = end - -(-size // 4) * 4
    return (
        peer_text(message[start : start + size].decode(errors='replace'), _LONGEST)
        if start >= ENCAPSULATION_SIZE
        else ''
    )
