"""The forms in which requests and replies travel, by vendor. There is no I/O here.

    INLINE  Fast DDS, and goalwire itself: only the message. The inline QoS of a request names the reader to
            which its reply is to go; the inline QoS of a reply names the request.
    HEADER  Cyclone DDS: sixteen bytes before the message (service_header.py), which the reply repeats.
    PLAIN   Connext (its `extended` mapping): a request is only the message. Its writer and number name it.
            A reply has the form of INLINE.

A client uses the form of the server's vendor. A server answers in the form of the request, which can be seen
from the request itself. Connext's `basic` mapping is not supported.

Sources: rmw_fastrtps_shared_cpp src/rmw_request.cpp, rmw_response.cpp; rmw_cyclonedds_cpp src/serdata.hpp;
rmw_connextdds_common src/common/rmw_impl.cpp; OMG DDS-RPC 1.0, 7.8.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import NamedTuple

from goalwire.errors import RemoteError, peer_text
from goalwire.rtps.protocol.parameters import (
    new_identity,
    read_list,
    read_related_sample,
    write_related_sample,
)
from goalwire.rtps.protocol.primitives import GUID_SIZE, SampleIdentity, is_writer
from goalwire.transport.dds.description import GUID_PREFIX_SIZE
from goalwire.transport.dds.service_header import Header, refusal, refusal_reason, unwrap, wrap

CYCLONE_VENDOR = b'\x01\x10'
CONNEXT_VENDOR = b'\x01\x01'
UNKNOWN_NUMBER = -1
_REFUSAL = 0x8001
"""The parameter of a reply that refuses a request: vendor-specific, sent to goalwire's clients only."""
_LONGEST_REASON = 1000
_NO_MESSAGE = b'\0\1\0\0\0\0\0\0'


class Dialect(Enum):
    """The form of requests that a server's vendor expects."""

    INLINE = 'inline'
    HEADER = 'header'
    PLAIN = 'plain'


def dialect_of(vendor: bytes) -> Dialect:
    """Return the form of requests that participants of this vendor expect."""
    if vendor == CYCLONE_VENDOR:
        return Dialect.HEADER
    return Dialect.PLAIN if vendor == CONNEXT_VENDOR else Dialect.INLINE


def request_qos(reply_reader: bytes) -> bytes:
    """Return the inline QoS of a client's requests in the dialect INLINE."""
    return write_related_sample(SampleIdentity(reply_reader, UNKNOWN_NUMBER))


# ---- what a server reads, and writes


class ReturnAddress(NamedTuple):
    """The receiver of a request's reply, and the data by which the reply names the request."""

    reader: bytes
    """The GUID of the reader that the reply is for; empty if the request does not name it."""
    related: SampleIdentity
    """The request's identity for the reply's inline QoS; unused if there is a header."""
    header: Header | None = None


_new_address: Callable[[tuple[bytes, SampleIdentity, None]], ReturnAddress] = partial(
    tuple.__new__, ReturnAddress
)
"""Makes a ReturnAddress by tuple.__new__, which runs no Python code."""


def read_request(
    qos: bytes, payload: bytes | bytearray, writer: bytes, number: int, *, has_header: bool
) -> tuple[ReturnAddress, int, bytes | bytearray]:
    """Return a request's return address, the number that its client gave it, and its message.

    `writer` and `number` are those of the sample. `has_header` is True for a participant of Cyclone DDS.
    Raises RemoteError.
    """
    related = read_related_sample(qos) if qos else None
    if related is not None and any(related.guid):
        guid = related.guid
        is_readers = not is_writer(guid[GUID_PREFIX_SIZE:])
        address = _new_address((guid if is_readers else b'', new_identity((guid, number)), None))
        return address, number, payload
    # A client on Connext may put the header in, too: its first field is the end of the writer's GUID.
    if has_header or payload[4:12] == writer[GUID_SIZE - 8 :]:
        header, message = unwrap(bytes(payload))
        return ReturnAddress(b'', SampleIdentity(writer, number), header), header.sequence, message
    return ReturnAddress(b'', SampleIdentity(writer, number)), number, payload


def write_reply(to: ReturnAddress, message: bytes) -> tuple[bytes, bytes]:
    """Return the payload and the inline QoS of a reply."""
    if to.header is not None:
        return wrap(to.header, message), b''
    return message, write_related_sample(to.related)


def write_refusal(to: ReturnAddress, reason: str) -> tuple[bytes, bytes]:
    """Return the payload and the inline QoS that tell goalwire's client that no answer will come."""
    if to.header is not None:
        return refusal(to.header, reason), b''
    text = reason.encode()[:_LONGEST_REASON]
    return _NO_MESSAGE, write_related_sample(to.related, [(_REFUSAL, len(text).to_bytes(4, 'little') + text)])


# ---- what a client reads


class Reply(NamedTuple):
    """A reply's content: the request that it answers, and the message or the refusal."""

    client: bytes | int
    """The client that the reply is for: the GUID that its request named, or the client in the header."""
    number: int
    """The number of the request."""
    message: bytes | bytearray
    refusal: str | None = None
    """The reason, if the reply is a refusal."""


_new_reply: Callable[[tuple[bytes, int, bytes | bytearray, str | None]], Reply] = partial(
    tuple.__new__, Reply
)


def read_reply(qos: bytes, payload: bytes | bytearray) -> Reply | None:
    """Read a reply; None if it names no request in a form that is known here. Raises RemoteError."""
    related = read_related_sample(qos) if qos else None
    if related is not None:
        guid, number = related
        return _new_reply((guid, number, payload, None if len(qos) <= _PLAIN_QOS_SIZE else _reason(qos)))
    try:
        (client, number), message = unwrap(bytes(payload))
    except RemoteError:
        return None  # a reply of a vendor whose form is not known here
    if number < 0:
        return Reply(client, -number, b'', refusal_reason(message))
    return Reply(client, number, message)


_PLAIN_QOS_SIZE = len(write_related_sample(SampleIdentity(bytes(GUID_SIZE), 0)))


def _reason(qos: bytes) -> str | None:
    for pid, value in read_list(qos):
        if pid == _REFUSAL and len(value) >= 4:
            size = int.from_bytes(value[:4], 'little')
            return peer_text(value[4 : 4 + size].decode(errors='replace'), _LONGEST_REASON)
    return None
