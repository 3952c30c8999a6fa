"""What zenoh brings becomes a sample, or says what is wrong with it."""

from __future__ import annotations

from time import time_ns
from typing import NamedTuple

import pytest

from goalwire.errors import RemoteError
from goalwire.transport.zenoh.attachment import GID_SIZE, encode
from goalwire.transport.zenoh.samples import sample_of
from goalwire.transport.zenoh.wire import Message

GID = bytes(range(16))
OLDER = b'\x0fsequence_number%b\x10source_timestamp%b\x0asource_gid\x10%b'


class Came(NamedTuple):
    """What sample_of looks at."""

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
