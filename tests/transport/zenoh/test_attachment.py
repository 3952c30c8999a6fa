"""The attachment that travels beside a message, and the sample that is read from the wire."""

from __future__ import annotations

from time import time_ns
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import RemoteError
from goalwire.transport.zenoh.attachment import GID_SIZE, decode, encode, sample_of
from goalwire.transport.zenoh.wire import Message

GID = bytes(range(16))
COUNTS = st.integers(0, 2**63 - 1)


def older_form(sequence: int, timestamp: int, gid: bytes) -> bytes:
    """The 77 bytes, written out field by field."""
    return (
        b'\x0fsequence_number'
        + sequence.to_bytes(8, 'little')
        + b'\x10source_timestamp'
        + timestamp.to_bytes(8, 'little')
        + b'\x0asource_gid'
        + b'\x10'
        + gid
    )


def test_an_attachment_is_sequence_time_length_and_gid() -> None:
    assert encode(1, 2, GID_SIZE, GID) == b'\x01' + bytes(7) + b'\x02' + bytes(7) + b'\x10' + GID


def test_it_is_what_zenohs_own_serializer_writes() -> None:
    from zenoh import ext

    fields = (ext.Int64(5), ext.Int64(1_700_000_000_000_000_000), GID)
    assert encode(5, 1_700_000_000_000_000_000, GID_SIZE, GID) == ext.z_serialize(fields).to_bytes()


@given(COUNTS, COUNTS, st.binary(min_size=16, max_size=16))
def test_what_is_written_is_read(sequence: int, timestamp: int, gid: bytes) -> None:
    assert decode(encode(sequence, timestamp, GID_SIZE, gid)) == (sequence, timestamp, gid)


@given(COUNTS, COUNTS, st.binary(min_size=16, max_size=16))
def test_the_older_form_is_read_too(sequence: int, timestamp: int, gid: bytes) -> None:
    data = older_form(sequence, timestamp, gid)
    assert len(data) == 77
    assert decode(data) == (sequence, timestamp, gid)


@given(st.binary(max_size=120))
def test_anything_else_is_refused_as_the_peers_fault(data: bytes) -> None:
    try:
        sequence, timestamp, gid = decode(data)
    except RemoteError:
        return
    assert len(gid) == 16
    assert sequence >= 0
    assert timestamp >= 0


@pytest.mark.parametrize(
    ('data', 'says'),
    [
        (b'', '0 bytes'),
        (encode(1, 1, GID_SIZE, GID)[:-1], '32 bytes'),
        (encode(1, 1, GID_SIZE, GID) + b'\0', '34 bytes'),
        (encode(1, 1, GID_SIZE, GID)[:16] + b'\x11' + GID, '17 bytes'),
        (encode(-1, 1, GID_SIZE, GID), 'negative'),
        (encode(1, -1, GID_SIZE, GID), 'negative'),
        (bytes(77), 'field names'),
    ],
)
def test_the_reason_is_named(data: bytes, says: str) -> None:
    with pytest.raises(RemoteError, match=says):
        decode(data)


OLDER = b'\x0fsequence_number%b\x10source_timestamp%b\x0asource_gid\x10%b'


class Came(NamedTuple):
    """A message with the fields that sample_of looks at."""

    attachment: bytes | None
    payload: bytes | None
    key: str = ''
    timestamp: None = None
    source_info: None = None


def came(attachment: bytes | None, payload: bytes | None = b'hello') -> Message:
    return Came(attachment, payload)


def test_a_sample_has_the_payload_and_what_travels_beside_it() -> None:
    before = time_ns()
    sample = sample_of(came(encode(7, 8, GID_SIZE, GID)))
    assert sample[:3] + sample[4:] == (b'hello', 7, 8, GID)
    assert before <= sample.received_timestamp <= time_ns()


def test_the_older_attachment_is_read_too() -> None:
    older = OLDER % ((7).to_bytes(8, 'little'), (8).to_bytes(8, 'little'), GID)
    sample = sample_of(came(older))
    assert (sample.sequence, sample.source_timestamp, sample.gid) == (7, 8, GID)


@pytest.mark.parametrize(
    ('carrier', 'says'),
    [
        (came(None), 'there is none'),
        (came(b'short'), '5 bytes'),
        (came(encode(-1, 1, GID_SIZE, GID)), 'negative'),
        (came(encode(1, -1, GID_SIZE, GID)), 'negative'),
        (came(encode(1, 1, 17, GID)), '17 bytes'),
        (came(encode(1, 1, GID_SIZE, GID), None), 'request 1 has no payload'),
    ],
    ids=['no attachment', 'short', 'negative sequence', 'negative time', 'a longer gid', 'no payload'],
)
def test_what_breaks_the_rules_is_the_peers_fault(carrier: Message, says: str) -> None:
    with pytest.raises(RemoteError, match=says):
        sample_of(carrier)
