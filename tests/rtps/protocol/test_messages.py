"""Submessages: both orders of bytes, unknown ones, and what is malformed."""

from __future__ import annotations

import struct

import pytest
from helpers.rtps_captured import packets
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.rtps.protocol.announcements import read_endpoint, read_participant
from goalwire.rtps.protocol.messages import (
    ACKNACK,
    DATA,
    GAP,
    HEARTBEAT,
    AckNack,
    Data,
    DataFrag,
    Gap,
    Heartbeat,
    HeartbeatFrag,
    NackFrag,
    check_header,
    header,
    read_body,
    split,
)
from goalwire.rtps.protocol.primitives import NumberSet, RtpsError

READER, WRITER = b'\0\0\1\4', b'\0\0\2\3'
SAMPLES = [packet.data for packet in packets()]


def _read_all(packet: bytes) -> list[object]:
    check_header(packet)
    return [read_body(kind, packet, at, end, flags) for kind, flags, at, end in split(packet)]


@pytest.mark.parametrize(
    'body',
    [
        Data(READER, WRITER, 2**40 + 1, b'', b'\0\1\0\0abcd'),
        Data(READER, WRITER, 1, b'\x70\0\x10\0' + b'k' * 16 + b'\1\0\0\0', None),
        Data(READER, WRITER, 1, b'', b'\0\3\0\0', is_key=True),
        DataFrag(READER, WRITER, 7, 2, 1, 1000, 70000, b'', b'x' * 1000),
        Heartbeat(READER, WRITER, 1, 0, 5, is_final=True, asserts_liveliness=True),
        AckNack(READER, WRITER, NumberSet.of(2**33, [2**33, 2**33 + 255]), -1, is_final=True),
        Gap(READER, WRITER, 3, NumberSet.of(9, [10, 11])),
        NackFrag(READER, WRITER, 3, NumberSet.of(4, [4, 5]), 1),
        HeartbeatFrag(READER, WRITER, 3, 17, 1),
    ],
    ids=lambda body: type(body).__name__,
)
def test_what_is_written_is_read(body: Data) -> None:
    assert _read_all(header(b'p' * 12) + body.encode()) == [body]


def test_big_endian_is_read() -> None:
    body = struct.pack('>4s4siIIIIIIi', READER, WRITER, 1, 2, 40, 0x80000000, 0x01000000, 0, 0, 9)
    packet = header(b'p' * 12) + struct.pack('>BBH', ACKNACK, 0, 32) + body[:24] + body[24:28] + body[36:40]
    (read,) = _read_all(packet[:22] + packet[22:])
    assert isinstance(read, AckNack)
    assert read.missing.base == 2**32 + 2
    assert read.missing.numbers()[0] == read.missing.base


def test_a_length_of_zero_reaches_to_the_end() -> None:
    data = Data(READER, WRITER, 1, b'', b'y' * 70_000)
    assert _read_all(header(b'p' * 12) + data.encode()) == [data]


def test_unknown_submessages_are_skipped_by_length() -> None:
    known = Heartbeat(READER, WRITER, 1, 4, 5)
    for unknown in (b'\x80\1\4\0abcd', b'\x33\0\0\4abcd', b'\1\1\0\0'):
        assert _read_all(header(b'p' * 12) + unknown + known.encode())[1] == known


@pytest.mark.parametrize(
    ('kind', 'body'),
    [
        (DATA, b'\0' * 8),
        (DATA, struct.pack('<HH4s4siI', 0, 900, READER, WRITER, 0, 1)),
        (DATA, struct.pack('<HH4s4siI', 0, 16, READER, WRITER, 0, 0)),
        (HEARTBEAT, struct.pack('<4s4siIiIi', READER, WRITER, 0, 9, 0, 3, 1)),
        (HEARTBEAT, struct.pack('<4s4siIiIi', READER, WRITER, -1, 9, 0, 3, 1)),
        (ACKNACK, struct.pack('<4s4siIIi', READER, WRITER, 0, 1, 257, 1)),
        (ACKNACK, struct.pack('<4s4siIIi', READER, WRITER, 0, 1, 32, 1)),
        (GAP, struct.pack('<4s4siIiII', READER, WRITER, 0, 9, 0, 3, 0)),
    ],
)
def test_what_is_malformed_costs_the_packet(kind: int, body: bytes) -> None:
    packet = header(b'p' * 12) + struct.pack('<BBH', kind, 1, len(body)) + body
    with pytest.raises(RtpsError):
        _read_all(packet + Heartbeat(READER, WRITER, 1, 4, 5).encode())


@given(st.data())
@settings(max_examples=300, deadline=None)
def test_mutated_packets_raise_nothing_else(data: st.DataObject) -> None:
    packet = bytearray(data.draw(st.sampled_from(SAMPLES)))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(packet) - 1))
        packet[at] = data.draw(st.sampled_from([0, 1, 4, 0x7F, 0x80, 0xFF]))
    cut = bytes(packet[: data.draw(st.integers(0, len(packet)))])
    try:
        found = _read_all(cut)
    except RtpsError:
        return
    for body in found:
        if isinstance(body, Data) and body.payload is not None:
            for read in (read_participant, read_endpoint):
                try:
                    read(body.payload)
                except RtpsError:
                    continue


@given(st.integers(1, 2**40), st.sets(st.integers(0, 300)))
def test_sets_have_the_numbers_that_fit(base: int, offsets: set[int]) -> None:
    numbers = sorted(base + offset for offset in offsets)
    made = NumberSet.of(base, numbers)
    assert made.numbers() == [number for number in numbers if number < base + 256]
