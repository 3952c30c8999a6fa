"""The binary frames of the protocol (foxglove/ws-protocol, docs/spec.md), which are little endian."""

from __future__ import annotations

import struct
from typing import NamedTuple

SUBPROTOCOLS = ('foxglove.websocket.v1', 'foxglove.sdk.v1')
ENCODING = 'cdr'
INFO, WARNING, ERROR = 0, 1, 2


class BadFrameError(ValueError):
    """A frame is too short or of an unknown kind."""


class ClientMessage(NamedTuple):
    """A message that a client publishes."""

    channel: int
    data: bytes


class ServiceRequest(NamedTuple):
    """A call of a client."""

    service: int
    call: int
    encoding: str
    data: bytes


def message(subscription: int, time: int, data: bytes) -> bytes:
    """Return a message for a subscriber; `time` is in ns since 1970."""
    return struct.pack('<BIQ', 1, subscription, time) + data


def time(stamp: int) -> bytes:
    """Return a frame with the robot's time, in ns."""
    return struct.pack('<BQ', 2, stamp)


def response(service: int, call: int, data: bytes) -> bytes:
    """Return the response to a call."""
    encoding = ENCODING.encode()
    return struct.pack('<BIII', 3, service, call, len(encoding)) + encoding + data


def asset(request: int, data: bytes, problem: str = '') -> bytes:
    """Return the response with a file, or with the error text."""
    text = problem.encode()
    return struct.pack('<BIBI', 4, request, bool(problem), len(text)) + text + data


def read(frame: bytes) -> ClientMessage | ServiceRequest:
    """Read a frame of a client. Raises BadFrameError."""
    try:
        if frame[:1] == b'\x01':
            return ClientMessage(struct.unpack_from('<I', frame, 1)[0], frame[5:])
        if frame[:1] == b'\x02':
            service, call, length = struct.unpack_from('<III', frame, 1)
            end = 13 + length
            if end > len(frame):
                raise BadFrameError('the frame of a call is too short')
            return ServiceRequest(service, call, frame[13:end].decode('utf-8', 'replace'), frame[end:])
    except struct.error:
        raise BadFrameError('the frame is too short') from None
    raise BadFrameError(f'there is no binary frame of the kind {frame[:1].hex() or "nothing"}')
