"""The forms in which requests and replies travel, by vendor. Pure.

    INLINE  Fast DDS, and goalwire itself: the message alone; the inline QoS of a reply names the request. The
            inline QoS of a request names the reader to which its reply is to go.
    HEADER  Cyclone DDS: sixteen bytes before the message (service_header.py), which the reply repeats.
    PLAIN   Connext (its `extended` mapping): a request is the message alone, named by its writer and number.
            A reply is as of INLINE.

A client speaks to a server as the server's vendor does. A server answers as the request was made: requests
tell their form themselves. Connext's `basic` mapping is not spoken.

Sources: rmw_fastrtps_shared_cpp src/rmw_request.cpp, rmw_response.cpp; rmw_cyclonedds_cpp src/serdata.hpp;
rmw_connextdds_common src/common/rmw_impl.cpp; OMG DDS-RPC 1.0, 7.8.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from goalwire.errors import RemoteError, peer_text
from goalwire.rtps.protocol.parameters import read_list, related_sample, write_related_sample
from goalwire.rtps.protocol.primitives import GUID_SIZE, SampleIdentity, is_writer
from goalwire.transport.dds.description import GUID_PREFIX_SIZE
from goalwire.transport.dds.service_header import Header, refusal, refusal_reason, unwrap, wrap

CYCLONE_VENDOR = b'\x01\x10'
CONNEXT_VENDOR = b'\x01\x01'
UNKNOWN_NUMBER = -1
_REFUSAL = 0x8001
"""The parameter by which goalwire refuses a request: a vendor's own, sent to goalwire's clients alone."""
_LONGEST_REASON = 1000
_NO_MESSAGE = b'\0\1\0\0\0\0\0\0'


class Dialect(Enum):
    """How a server's vendor wants its requests."""

    INLINE = 'inline'
    HEADER = 'header'
    PLAIN = 'plain'


def dialect_of(vendor: bytes) -> Dialect:
    """Return how a participant of this vendor wants its requests."""
    if vendor == CYCLONE_VENDOR:
        return Dialect.HEADER
    return Dialect.PLAIN if vendor == CONNEXT_VENDOR else Dialect.INLINE


def request_qos(reply_reader: bytes) -> bytes:
    """Return the inline QoS of a client's requests in the dialect INLINE."""
    return write_related_sample(SampleIdentity(reply_reader, UNKNOWN_NUMBER))


# ---- what a server reads, and writes


class ReturnAddress(NamedTuple):
    """To whom the reply of a request goes, and how it names the request."""

    reader: bytes
    """The GUID of the reader that the reply is for; nothing if the request does not tell."""
    related: SampleIdentity
    """What the reply's inline QoS says, unless there is a header."""
    header: Header | None = None


def read_request(
    qos: bytes, payload: bytes, writer: bytes, number: int, *, has_header: bool
) -> tuple[ReturnAddress, int, bytes]:
    """Return a request's return address, its number as its client counts, and its message.

    `writer` and `number` are those of the sample; `has_header`: its participant is one of Cyclone DDS, or has
    said so. Raises RemoteError.
    """
    related = related_sample(qos) if qos else None
    if related is not None and any(related.guid):
        answered = SampleIdentity(related.guid, number)
        is_readers = not is_writer(related.guid[GUID_PREFIX_SIZE:])
        return ReturnAddress(related.guid if is_readers else b'', answered), number, payload
    if has_header or payload[4:12] == writer[GUID_SIZE - 8 :]:  # Connext's mode for Cyclone DDS
        header, message = unwrap(payload)
        return ReturnAddress(b'', SampleIdentity(writer, number), header), header.sequence, message
    return ReturnAddress(b'', SampleIdentity(writer, number)), number, payload


def write_reply(to: ReturnAddress, message: bytes) -> tuple[bytes, bytes]:
    """Return the payload and the inline QoS of a reply."""
    if to.header is not None:
        return wrap(to.header, message), b''
    return message, write_related_sample(to.related)


def write_refusal(to: ReturnAddress, reason: str) -> tuple[bytes, bytes]:
    """Return the payload and the inline QoS that tell a client of goalwire that nothing will be answered."""
    if to.header is not None:
        return refusal(to.header, reason), b''
    text = reason.encode()[:_LONGEST_REASON]
    return _NO_MESSAGE, write_related_sample(to.related, [(_REFUSAL, len(text).to_bytes(4, 'little') + text)])


# ---- what a client reads


class Reply(NamedTuple):
    """What a reply says."""

    client: bytes | int
    """Whose request it answers: the GUID that the request has named, or the client of its header."""
    number: int
    """The request's."""
    message: bytes
    refusal: str | None = None
    """The reason, if it is a refusal."""


def read_reply(qos: bytes, payload: bytes) -> Reply | None:
    """Return what a reply says; None if it names no request in any of the forms. Raises RemoteError."""
    related = related_sample(qos) if qos else None
    if related is not None:
        is_plain = len(qos) <= _PLAIN_QOS_SIZE
        return Reply(related.guid, related.number, payload, None if is_plain else _reason(qos))
    try:
        (client, number), message = unwrap(payload)
    except RemoteError:
        return None  # a vendor's that names its requests otherwise
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
