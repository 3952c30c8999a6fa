"""Sequence numbers, fragments, and the queue before a socket."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.channels import (
    CONTROL_CHANNEL,
    DATA_CHANNEL,
    MASK,
    PieceBudget,
    Reassembly,
    ReceivedNumbers,
    SendQueue,
    channel_of,
    fragment_head,
    frame_head,
    pieces,
)
from goalwire.zenoh.protocol.primitives import ZenohProtocolError


@pytest.mark.parametrize(
    ('channel', 'head'),
    [
        (DATA_CHANNEL, '25'),
        (DATA_CHANNEL - 1, '05'),
        (CONTROL_CHANNEL, 'a5'),
        (channel_of(1), 'a5'),
        (channel_of(7), 'a5'),
    ],
)
def test_frames_begin_as_captured(channel: int, head: str) -> None:
    data = frame_head(channel, 92331340)
    assert data[:5].hex() == head + 'ccba832c'
    assert data[5:] == (b'' if channel >> 1 == 5 else bytes((0x31, channel >> 1)))


def test_fragments_begin_as_captured() -> None:
    assert fragment_head(channel_of(1), 1, marks_first=True, more=True).hex(' ') == 'e6 81 80 80 00 b1 01 02'
    assert fragment_head(channel_of(1), 1, marks_first=False, more=True).hex(' ') == 'e6 81 80 80 00 31 01'
    assert fragment_head(channel_of(1), 1, marks_first=False, more=False).hex(' ') == 'a6 81 80 80 00 31 01'
    assert fragment_head(DATA_CHANNEL, 1, marks_first=True, more=True).hex(' ') == 'e6 81 80 80 00 02'
    assert fragment_head(DATA_CHANNEL, 1, marks_first=False, more=True)[0] == 0x66
    assert fragment_head(DATA_CHANNEL, 1, marks_first=False, more=False)[0] == 0x26


@pytest.mark.parametrize(
    ('last', 'number', 'gap'),
    [
        (5, 6, 1),
        (5, 5, 0),
        (5, 100, 95),
        (100, 50, 0),
        (5, 5 + 2**27 - 1, 2**27 - 1),
        (5, 5 + 2**27, 0),
        (MASK, 0, 1),
    ],
)
def test_a_number_is_taken_where_it_is_ahead(last: int, number: int, gap: int) -> None:
    numbers = ReceivedNumbers((last + 1) & MASK)
    assert numbers.advance(DATA_CHANNEL, number) == gap
    assert numbers.last[DATA_CHANNEL] == (number if gap else last)
    assert numbers.last[CONTROL_CHANNEL] == last


def test_a_number_of_more_than_28_bits_is_none() -> None:
    with pytest.raises(ZenohProtocolError, match='28 bits'):
        ReceivedNumbers(0).advance(DATA_CHANNEL, MASK + 1)


def join(parts: list[bytes], *, has_marks: bool = True, limit: int = 1000) -> bytes | None:
    whole = Reassembly(has_marks=has_marks, budget=PieceBudget(limit))
    last = len(parts) - 1
    for at, part in enumerate(parts):
        result = whole.add(part, gap=1, first=not at and has_marks, more=at != last, given_up=False)
    return result


@given(st.binary(min_size=1, max_size=100), st.integers(1, 30), st.booleans())
def test_a_message_in_pieces_comes_whole(message: bytes, size: int, has_marks: bool) -> None:
    parts = [message[:3], message[3:]]
    cut = [b''.join(piece) for piece in pieces(parts, size)]
    assert all(len(piece) <= size for piece in cut)
    assert join(cut, has_marks=has_marks) == message


def test_pieces_that_do_not_begin_with_the_first_are_thrown_away() -> None:
    whole = Reassembly(has_marks=True, budget=PieceBudget(100))
    assert whole.add(b'b', gap=1, first=False, more=False, given_up=False) is None


def test_a_gap_between_pieces_loses_the_message_and_not_the_next() -> None:
    whole = Reassembly(has_marks=True, budget=PieceBudget(100))
    assert whole.add(b'a', gap=1, first=True, more=True, given_up=False) is None
    assert whole.add(b'b', gap=2, first=False, more=False, given_up=False) is None
    assert whole.add(b'c', gap=1, first=True, more=False, given_up=False) == b'c'


def test_a_message_that_its_sender_gives_up_is_thrown_away() -> None:
    whole = Reassembly(has_marks=True, budget=PieceBudget(100))
    whole.add(b'a', gap=1, first=True, more=True, given_up=False)
    assert whole.add(b'', gap=1, first=False, more=True, given_up=True) is None
    assert whole.add(b'b', gap=1, first=False, more=False, given_up=False) is None


def test_a_message_larger_than_the_limit_is_refused_before_it_is_whole() -> None:
    with pytest.raises(ZenohProtocolError, match='more than 10 bytes'):
        join([b'12345', b'67890', b'1'], limit=10)


@pytest.mark.parametrize('piece', [b'', b'x'])
def test_pieces_that_hold_next_to_nothing_are_not_kept_for_ever(
    piece: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'MOST_PIECES', 100)
    with pytest.raises(ZenohProtocolError, match='or 100 pieces'):
        join([piece] * 102, limit=10_000)


def add(whole: Reassembly, piece: bytes, *, first: bool = False, more: bool = True) -> bytes | None:
    return whole.add(piece, gap=1, first=first, more=more, given_up=False)


def test_unfinished_messages_of_all_channels_share_one_budget() -> None:
    session = PieceBudget(150)
    link, other = PieceBudget(100, session), PieceBudget(100, session)
    one, two, far = (Reassembly(has_marks=True, budget=each) for each in (link, link, other))
    add(one, bytes(60), first=True)
    add(two, bytes(40), first=True)
    assert add(two, b'x') is None
    assert two.is_refused
    assert add(two, b'y', more=False) is None
    assert add(far, bytes(90), first=True) is None
    refused = [far.is_refused]
    assert add(far, b'x') is None
    assert [*refused, far.is_refused] == [False, True]
    assert add(one, b'', more=False) == bytes(60)
    assert (link.used, other.used, session.used) == (0, 0, 0)


def test_an_unfinished_message_is_thrown_away_when_nothing_of_it_comes() -> None:
    budget = PieceBudget(100)
    whole = Reassembly(has_marks=True, budget=budget)
    assert not whole.is_stale(0.0)
    add(whole, b'a', first=True)
    assert not whole.is_stale(1.0)
    add(whole, b'b')
    assert not whole.is_stale(bounds.STALE_S + 1.5)
    assert not whole.is_stale(2 * bounds.STALE_S)
    assert whole.is_stale(2 * bounds.STALE_S + 1.5)
    assert budget.used == 0


def test_batches_leave_by_priority_and_a_begun_one_is_finished() -> None:
    queue = SendQueue()
    queue.add(5, (b'data1', b'more1'))
    queue.add(5, (b'data2',))
    assert queue.next_buffers(1) == [b'data1']
    queue.note_written(2)
    queue.add(0, (b'control',))
    assert b''.join(bytes(each) for each in queue.next_buffers(9)) == b'ta1more1controldata2'
    queue.note_written(queue.size)
    assert not queue
    assert queue.next_buffers(9) == []


@given(
    st.lists(st.tuples(st.integers(0, 7), st.binary(min_size=1, max_size=9)), max_size=20), st.integers(1, 7)
)
def test_everything_queued_is_written_once_in_order(batches: list[tuple[int, bytes]], step: int) -> None:
    queue = SendQueue()
    for priority, batch in batches:
        queue.add(priority, (batch,))
    out = bytearray()
    while queue:
        some = b''.join(bytes(each) for each in queue.next_buffers(3))[:step]
        out += some
        queue.note_written(len(some))
    assert out == b''.join(batch for _, batch in sorted(batches, key=lambda each: each[0]))
    assert queue.size == 0
