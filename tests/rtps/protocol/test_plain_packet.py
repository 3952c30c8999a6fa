"""A plain packet that is read in one go gives the same as one read submessage by submessage."""

from __future__ import annotations

from random import Random

from helpers.rtps_captured import packets

from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.messages import (
    HEADER_SIZE,
    INFO_DST,
    INFO_TS,
    INVALIDATE,
    LITTLE,
    MAGIC,
    TIME,
    VENDOR,
    VERSION,
    AckNack,
    Data,
    DataFrag,
    Heartbeat,
    NackFrag,
    info_dst,
    info_ts,
    read_body,
    split,
)
from goalwire.rtps.protocol.parameters import write_related_sample
from goalwire.rtps.protocol.plain_packet import read_plain, read_plain_fragments
from goalwire.rtps.protocol.primitives import PREFIX_SIZE, RtpsError, SampleIdentity, decode_time

PLAIN_ONES = 40
"""So many of the captured packets are plain at least."""
PLAIN_FRAGMENTS = 1
"""So many of those with fragments are plain at least."""


def _read_slowly(packet: bytes) -> list[object]:
    """Return the samples of a packet with the readers that they are for, and what else is in it."""
    time: int | None = None
    found: list[object] = []
    for kind, flags, at, end in split(packet):
        if kind == INFO_TS:
            time = None
            if not flags & INVALIDATE and end - at >= 8:
                time = decode_time(*TIME[flags & LITTLE].unpack_from(packet, at))
            continue
        body = read_body(kind, packet, at, end, flags)
        if isinstance(body, Data):
            sample = Sample(
                packet[8:HEADER_SIZE] + body.writer, body.number, time, body.payload, body.qos, body.is_key
            )
            found.append((body.reader, sample))
        elif body is not None:
            found.append(body)
    return found


def _whom(packet: bytes) -> bytes:
    """Return whom a packet is for, if it says so first."""
    at = HEADER_SIZE + 4
    return packet[at : at + PREFIX_SIZE] if packet[HEADER_SIZE] == INFO_DST else bytes(PREFIX_SIZE)


def test_all_captured_packets_are_read_alike() -> None:
    plain = 0
    for captured in packets():
        packet = captured.data
        found = read_plain(packet, packet[8:HEADER_SIZE], _whom(packet))
        if found is not None:
            plain += 1
            assert _read_slowly(packet) == [found]
    assert plain >= PLAIN_ONES


def test_all_captured_fragments_are_read_alike() -> None:
    plain = 0
    for captured in packets():
        packet = captured.data
        found = read_plain_fragments(memoryview(packet), _whom(packet))
        if found is not None:
            plain += 1
            fragments, time = found
            assert _read_slowly(packet) == [fragments]
            assert packet[HEADER_SIZE] == INFO_DST or time == _time_of(packet)
    assert plain >= PLAIN_FRAGMENTS


def _time_of(packet: bytes) -> int:
    """Return the time that a packet without INFO_DST begins with."""
    return decode_time(*TIME[LITTLE].unpack_from(packet, HEADER_SIZE + 4))


def test_mutated_fragments_are_read_alike_or_not_in_one_go() -> None:
    random = Random(8)
    fragments = DataFrag(b'\0\0\1\4', b'\0\0\2\3', 7, 2, 1, 64, 1000, b'', bytes(range(64)))
    related = write_related_sample(SampleIdentity(bytes(range(16)), 9))
    head = MAGIC + VERSION + VENDOR + bytes(range(12))
    before = head + info_dst(bytes(12)) + info_ts(bytes(8))
    packets_of = [b''.join(each.parts(before)) for each in (fragments, fragments._replace(qos=related))]
    read = 0
    for _ in range(20_000):
        data = bytearray(random.choice(packets_of))
        for _ in range(random.randint(0, 3)):
            data[random.randrange(HEADER_SIZE, len(data))] = random.choice((0, 1, 4, 8, 0x7F, 0x80, 0xFF))
        packet = bytes(data[: random.randint(HEADER_SIZE, len(data))] if random.random() < 0.2 else data)
        try:
            found = read_plain_fragments(memoryview(packet), _whom(packet + bytes(20)))
        except RtpsError:
            continue
        if found is not None:
            read += 1
            assert _read_slowly(packet) == [found[0]]
    assert read > 1000


def test_a_packet_for_another_participant_is_not_plain() -> None:
    others = [each.data for each in packets() if each.data[HEADER_SIZE] == INFO_DST]
    assert others
    assert not any(read_plain(packet, packet[8:HEADER_SIZE], b'somebodyelse') for packet in others)


def test_mutated_packets_are_read_alike_or_not_in_one_go() -> None:
    random = Random(7)
    captured = [each.data for each in packets() if len(each.data) < 1000]
    read = 0
    for _ in range(20_000):
        data = bytearray(random.choice(captured))
        for _ in range(random.randint(1, 4)):
            data[random.randrange(HEADER_SIZE, len(data))] = random.choice((0, 1, 4, 8, 0x7F, 0x80, 0xFF))
        packet = bytes(data[: random.randint(HEADER_SIZE, len(data))] if random.random() < 0.2 else data)
        try:
            found = read_plain(packet, packet[8:HEADER_SIZE], _whom(packet + b'\0'))
        except RtpsError:
            continue
        if found is not None:
            read += 1
            assert _read_slowly(packet) == [found]
    assert read > 100


def test_acknowledgements_are_left_to_the_slow_way() -> None:
    for captured in packets():
        packet = captured.data
        if any(isinstance(each, (AckNack, NackFrag, Heartbeat)) for each in _read_slowly(packet)):
            assert read_plain(packet, packet[8:HEADER_SIZE], _whom(packet)) is None
