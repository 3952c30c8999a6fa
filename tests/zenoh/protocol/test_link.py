"""One link: what it takes, what ends it, how it sends, when it is dead. The cases of eclipse-zenoh 1.10.2."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from helpers.zenoh_protocol import Cable, Session, pair
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.channels import MASK, frame_head
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.link_messages import Init, Role
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT
from goalwire.zenoh.protocol.primitives import (
    EXPIRED,
    UNSUPPORTED,
    ZenohProtocolError,
    encode_padded,
    encode_text,
    encode_z,
)
from goalwire.zenoh.protocol.publication import Publication


class Receiver:
    """A session that is told bytes by hand on an open link."""

    def __init__(self) -> None:
        self.one, self.other, self.cable = pair()
        self.samples: list[Sample] = []
        self.other.declare_subscriber('e/**', self.samples.append)
        self.cable.carry()
        terms = self.cable.links[1].terms
        assert terms is not None
        self.next = terms.first_received
        self.link = self.cable.links[1]

    def batch(self, data: bytes) -> None:
        self.link.frames.receive(len(data).to_bytes(2, 'little') + data)

    def frame(self, message: bytes, number: int | None = None) -> None:
        if number is None:
            number, self.next = self.next, (self.next + 1) & MASK
        self.batch(b'\x25' + encode_z(number) + message)

    def heard(self) -> list[bytes]:
        taken = [bytes(sample.payload or b'') for sample in self.samples]
        self.samples.clear()
        return taken


def push(payload: bytes, key: str = 'e/a') -> bytes:
    return b'\x3d\x00' + encode_text(key) + b'\x01' + encode_z(len(payload)) + payload


@pytest.fixture
def receiver() -> Receiver:
    return Receiver()


def test_numbers_decide_what_is_taken(receiver: Receiver) -> None:
    start = receiver.next
    receiver.frame(push(b'first'), start)
    receiver.frame(push(b'again'), start)
    receiver.frame(push(b'gap'), start + 95 & MASK)
    receiver.frame(push(b'back'), start + 50 & MASK)
    receiver.batch(b'\x25' + encode_padded(start + 96 & MASK) + push(b'padded'))
    receiver.frame(push(b'too far'), start + 96 + 2**27 & MASK)
    assert receiver.heard() == [b'first', b'gap', b'padded']


def test_channels_count_on_their_own(receiver: Receiver) -> None:
    start = receiver.next
    for channel in (11, 10, 3, 15):
        receiver.batch(frame_head(channel, start) + push(b'%d' % channel))
    receiver.batch(b'\xa5' + encode_z((start + 1) & MASK) + b'\x31\x05' + push(b'explicit'))
    assert receiver.heard() == [b'11', b'10', b'3', b'15', b'explicit']


def test_several_messages_in_one_batch(receiver: Receiver) -> None:
    start = receiver.next
    second = b'\x25' + encode_z((start + 1) & MASK) + push(b'3')
    receiver.batch(b'\x25' + encode_z(start) + push(b'1') + push(b'2') + b'\x04' + second)
    receiver.link.frames.receive(b'\0\0')
    assert receiver.heard() == [b'1', b'2', b'3']


@pytest.mark.parametrize(
    'break_it',
    [
        lambda each: each.frame(push(b'hello')[:-1]),
        lambda each: each.frame(b'\x3d\x00\x7fe/a\x01\x00'),
        lambda each: each.frame(b'\x3d\xff\xff\x7f'),
        lambda each: each.batch(b'\x1f\x01'),
        lambda each: each.batch(b'\x07'),
        lambda each: each.batch(b'\x25' + encode_z(2**28) + push(b'')),
        lambda each: each.batch(b'\xa5' + encode_z(each.next) + b'\x31\x08' + push(b'')),
        lambda each: each.frame(b'\xbd\x00' + encode_text('e/a') + b'\x1e\x01\x00'),
        lambda each: each.frame(b'\xbd\x00' + encode_text('e/a') + b'\x7e\x01\x00'),
        lambda each: each.frame(b'\x3d\x00' + encode_text('e/a') + b'\x81\x12\x00'),
        lambda each: each.frame(b'\x3d\x80\x80\x04\x01a\x01\x00'),
        lambda each: each.frame(b'\x3d\x00\x01\xff\x01\x00'),
        lambda each: each.frame(b'\x9e\x21\x08\x22\x01\x00\x03a//'),
        lambda each: each.frame(b'\x9e\x21\x08\x08'),
        lambda each: each.frame(b'\x9c\x01\x01'),
        lambda each: each.batch(b'\xc1' + b'\x09'),
    ],
)
def test_what_ends_a_link(receiver: Receiver, break_it: Callable[[Receiver], None]) -> None:
    with pytest.raises(ZenohProtocolError):
        break_it(receiver)
    assert receiver.heard() == []


@pytest.mark.parametrize(
    'message',
    [
        b'\xbd\x00' + encode_text('e/a') + b'\x0e' + b'\x01\x01u',
        push(b'u') + b'\x3d\x70\x01a\x01\x00',
        push(b'u') + b'\x1b\x09\x70\x04\x01\x00',
        push(b'u') + b'\x1a\x09',
        push(b'u') + b'\xbe\x09\x21\x08\x1a',
        push(b'u') + b'\x9e\x21\x08\x03\x09',
        push(b'u') + b'\x9e\x21\x08\x05\x09',
        push(b'u') + b'\x9e\x21\x08\x87\x09\x5f\x02\0\0',
        push(b'u') + b'\x99\x05\x21\x08',
    ],
)
def test_what_ends_no_link(receiver: Receiver, message: bytes) -> None:
    receiver.frame(message)
    receiver.frame(push(b'after'))
    assert receiver.heard() == [b'u', b'after']


def test_a_link_without_priorities_uses_none_and_takes_none() -> None:
    other = Session(b'\xa1')
    link, wire = other.new_link(connects=False)
    init = Init(b'\xb1', Role.PEER, qos=False, patch=0).encode()
    link.frames.receive(len(init).to_bytes(2, 'little') + init)
    cookie = wire.take()[-16:]
    link.frames.receive(b'\x14\x00\x42\x3c\x05\x10' + cookie)
    said = wire.take()
    assert b'\x25' in said
    assert b'\xa5' not in said
    with pytest.raises(ZenohProtocolError, match='priority'):
        link.frames.receive(b'\x05\x00\xa5\x05\x31\x05\x04')


@settings(max_examples=10, deadline=None)
@given(st.integers(1, 7), st.integers(0, 140_000))
def test_bytes_come_in_any_pieces(step: int, size: int) -> None:
    payload = bytes(range(256)) * (size // 256)
    one, other, cable = pair(batch_size=5000)
    samples: list[Sample] = []
    other.declare_subscriber('k', samples.append)
    cable.carry()
    Publication(one, 'k').put(payload, b'a')

    def cut(data: bytes) -> Sequence[bytes]:
        size = step * 1000 + 1
        return [data[at : at + size] for at in range(0, len(data), size)]

    cable.carry(cut)
    assert [bytes(sample.payload or b'') for sample in samples] == [payload]
    assert cable.ends == [None, None]


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 30_000), min_size=1, max_size=20), st.booleans())
def test_large_and_small_messages_come_whole_however_the_stream_is_cut(cuts: list[int], merges: bool) -> None:
    one, other, cable = pair(batch_size=5000)
    samples: list[Sample] = []
    other.declare_subscriber('k', samples.append)
    cable.carry()
    sent = [b'%d' % number * (20_000 if number % 3 else 1) for number in range(6)]
    publication = Publication(one, 'k')
    for payload in sent:
        publication.put(payload, b'a')

    def cut(data: bytes) -> Sequence[bytes]:
        pieces: list[bytes] = []
        at = 0
        while at < len(data):
            size = 1 + cuts[len(pieces) % len(cuts)] * (3 if merges else 1)
            pieces.append(data[at : at + size])
            at += size
        return pieces

    cable.carry(cut)
    assert [bytes(sample.payload or b'') for sample in samples] == sent
    assert cable.ends == [None, None]
    assert not cable.links[1].frames.in_pieces


def full_wire() -> tuple[Session, Session, Cable, list[Sample]]:
    one, other, cable = pair()
    samples: list[Sample] = []
    other.declare_subscriber('k', samples.append)
    cable.carry()
    cable.wires[0].room = 0
    return one, other, cable, samples


def test_what_may_be_dropped_is_dropped_and_counted_where_too_much_waits() -> None:
    one, _, cable, samples = full_wire()
    publication = Publication(one, 'k')
    sent = QUEUE_LIMIT // 1000 + 100
    for number in range(sent):
        publication.put(b'%06d' % number + bytes(994))
    assert cable.wires[0].wants_room > 0
    assert cable.wires[0].waits == 0
    dropped = cable.links[0].outgoing.dropped
    assert 0 < dropped < 200
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert [int(bytes(each.payload or b'')[:6]) for each in samples] == list(range(sent - dropped))


def test_what_may_not_be_dropped_waits_for_room() -> None:
    one, _, cable, samples = full_wire()
    publication = Publication(one, 'k', droppable=False)
    for _ in range(3):
        publication.put(bytes(QUEUE_LIMIT))
    assert cable.wires[0].waits == 2
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert len(samples) == 3


def test_a_large_message_is_not_copied() -> None:
    one, _, cable, samples = full_wire()
    payload = bytes(300_000)
    Publication(one, 'k').put(payload, b'att')
    waiting = [
        each for each in cable.links[0].outgoing.queue.next_buffers(100) if isinstance(each, memoryview)
    ]
    assert sum(len(each) for each in waiting if each.obj is payload) == len(payload)
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert [(len(each.payload or b''), each.attachment) for each in samples] == [(300_000, b'att')]


@pytest.mark.parametrize('room', [1, 7, 100, 5000])
def test_what_the_socket_takes_in_part_is_finished_before_what_is_more_urgent(room: int) -> None:
    one, other, cable = pair()
    samples: list[Sample] = []
    other.declare_subscriber('k', samples.append)
    cable.carry()
    cable.wires[0].room = room
    Publication(one, 'k').put(bytes(6000))
    token = one.declare_token('t/1')
    tokens: list[Sample] = []
    other.watch_tokens('t/*', tokens.append, history=True)
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert len(samples) == len(tokens) == 1
    assert token
    assert cable.ends == [None, None]


def test_an_expression_is_taken_back_behind_the_messages_that_name_it() -> None:
    one, other, cable = pair()
    samples: list[Sample] = []
    other.declare_subscriber('a/*', samples.append)
    cable.carry()
    publication = Publication(one, 'a/b')
    publication.put(b'1')
    cable.carry()
    assert list(cable.links[1].peer.expressions.values()) == ['a/b']
    cable.wires[0].room = 0
    publication.put(b'2')
    publication.close()
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert [bytes(each.payload or b'') for each in samples] == [b'1', b'2']
    assert cable.links[1].peer.expressions == {}


def test_a_silent_link_says_that_it_lives_and_a_talking_one_need_not() -> None:
    one, _, cable = pair()
    link, wire = cable.links[0], cable.wires[0]
    link.outgoing.tick()
    assert wire.take() == b''  # it has just spoken
    link.outgoing.tick()
    assert wire.take() == b'\x01\x00\x04'
    one.declare_token('a')
    wire.take()
    link.outgoing.tick()
    assert wire.take() == b''


def test_a_link_is_dead_after_the_other_sides_lease_and_not_before() -> None:
    one, _, cable = pair(lease_ms=2000)
    link = cable.links[1]
    assert link.terms is not None
    assert link.terms.lease_ms == 2000
    now = 0.0
    for now in (0.0, 0.5, 1.0, 1.5, 1.99):
        link.check_lease(now)
    cable.links[0].outgoing.tick()
    cable.links[0].outgoing.tick()
    cable.carry()
    link.check_lease(now := now + 0.5)
    link.check_lease(now + 1.9)
    with pytest.raises(ZenohProtocolError, match='lease of 2 s') as caught:
        link.check_lease(now + 2.0)
    assert caught.value.reason == EXPIRED
    assert one.links


def test_close_comes_behind_what_was_sent_and_names_its_reason() -> None:
    one, _, cable = pair()
    one.declare_token('a')
    cable.links[0].close(UNSUPPORTED)
    one.declare_token('b')
    cable.carry()
    assert isinstance(cable.ends[1], ClosedByPeerError)
    assert f'reason {UNSUPPORTED}' in str(cable.ends[1])


def test_a_lost_link_takes_nothing_more() -> None:
    one, other, cable = pair()
    other.declare_subscriber('k', lambda _: None)
    cable.carry()
    cable.cut()
    Publication(one, 'k').put(b'x')
    assert cable.wires[0].take() == b''
    assert one.links == other.links == ()


def test_a_user_function_that_raises_breaks_no_link(receiver: Receiver) -> None:
    def fail(_: Sample) -> None:
        raise IndexError('mine')

    receiver.other.declare_subscriber('e/a', fail)
    receiver.frame(push(b'x'))
    assert [str(error) for error in receiver.other.failures] == ['mine']
    assert receiver.heard() == [b'x']
