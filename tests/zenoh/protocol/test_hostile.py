"""Damaged traffic: it is taken or ends its link with a documented error, and holds no memory."""

from __future__ import annotations

import tracemalloc

import pytest
from helpers.zenoh_captured import Batch, conversation
from helpers.zenoh_protocol import Session, Wire

from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.primitives import ZenohProtocolError
from goalwire.zenoh.protocol.queries import PendingQuery

BATCHES = conversation()
A_SAYS = [batch for batch in BATCHES if batch.sender == 'A']
B_SAYS = [batch for batch in BATCHES if batch.sender == 'B']
SAID = A_SAYS + B_SAYS[2:]


def look_at(sample: Sample) -> None:
    """Look at everything that is read when it is asked for."""
    assert isinstance(sample.timestamp, tuple | None)
    assert isinstance(sample.source_info, tuple | None)


def open_session() -> tuple[Session, Link, Wire]:
    """Return a session that has as much as there is to talk about, linked to A."""
    session = Session(b'\xb1\xb2\xb3\xb4')
    link, wire = session.new_link(connects=True)
    link.start()
    for batch in A_SAYS[:2]:
        link.frames.receive(batch.sent)
    session.declare_subscriber('**', look_at)
    session.declare_queryable('**', lambda query: query.answer(query.key, b'x'), complete=True)
    session.watch_tokens('@ros2_lv/**', lambda _: None, history=True)
    for _ in range(2):
        session.queries.add(
            PendingQuery('**', b'**', [link], 1e9, lambda _: None, lambda: None, takes_any_key=True)
        )
    return session, link, wire


def take(link: Link, data: bytes) -> bool:
    """Return whether the link goes on."""
    try:
        link.frames.receive(data)
    except (ZenohProtocolError, ClosedByPeerError) as error:
        return not str(error)
    return True


def number_of(batch: Batch, link: Link) -> bytes:
    """Return a batch whose sequence number is the next of its channel."""
    data = bytearray(batch.data)
    channel = 11 if data[0] & 0x80 == 0 else 2 * data[6] + 1
    last = link.frames._numbers.last[channel] + 1
    for at in range(4):
        data[1 + at] = last >> 7 * at & 0x7F | (0x80 if at < 3 else 0)
    return bytes(data)


FRAMES = [batch for batch in SAID if batch.data[0] & 0x1F == 5]


@pytest.mark.parametrize('batch', FRAMES, ids=lambda batch: f'{batch.sender}-{batch.says[:20]}')
def test_every_bit_of_captured_frames_may_be_wrong(batch: Batch) -> None:
    session, link, wire = open_session()
    for bit in range(8, 8 * len(batch.data)):
        data = bytearray(number_of(batch, link))
        data[bit // 8] ^= 1 << bit % 8
        if not take(link, len(data).to_bytes(2, 'little') + data):
            session.lose_link(link)
            session, link, wire = open_session()
        wire.take()
    unexpected = [each for each in session.failures if not isinstance(each, ZenohProtocolError)]
    assert unexpected == []


@pytest.mark.parametrize('batch', FRAMES, ids=lambda batch: f'{batch.sender}-{batch.says[:20]}')
def test_captured_frames_may_end_anywhere(batch: Batch) -> None:
    for size in range(5, len(batch.data)):
        _, link, _ = open_session()
        data = number_of(batch, link)[:size]
        take(link, len(data).to_bytes(2, 'little') + data)


@pytest.mark.parametrize('batch', A_SAYS[:2], ids=lambda batch: batch.says)
def test_handshakes_may_be_damaged(batch: Batch) -> None:
    for bit in range(8 * len(batch.data)):
        session = Session(b'\xb1\xb2\xb3\xb4')
        link, _ = session.new_link(connects=True)
        link.start()
        data = bytearray(batch.data)
        data[bit // 8] ^= 1 << bit % 8
        before = A_SAYS[0].sent if batch is A_SAYS[1] else b''
        take(link, before + len(data).to_bytes(2, 'little') + data)


@pytest.mark.parametrize(
    'message',
    [
        '3d00 fffffffff07f 61',
        '1d00 01 fffffffff0ff7f',
        'df012108 08 ffffffff0f',
        '9e2108 22 01 00 ffffffff0f',
        'df012108 06 ffffffff0f 00',
    ],
)
def test_a_length_that_is_not_there_takes_no_memory(message: str) -> None:
    session, link, _ = open_session()
    data = number_of(
        Batch('A', '', bytes.fromhex('2500000000') + bytes.fromhex(message.replace(' ', ''))), link
    )
    tracemalloc.start()
    goes_on = take(link, len(data).to_bytes(2, 'little') + data)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert not goes_on
    assert most < 1_000_000
    assert session.failures == []
