"""The bytes beside a message."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import RemoteError
from goalwire.transport.zenoh.attachment import GID_SIZE, decode, encode

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
