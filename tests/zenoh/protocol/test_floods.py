"""Small messages in floods share frames, none is lost or overtaken, and what is alike is read in one step."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.zenoh_protocol import Cable, Session
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.zenoh.protocol.bodies import LARGE, Sample
from goalwire.zenoh.protocol.channels import DATA_CHANNEL, SendQueue, channel_of
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.outgoing import HELD_SIZE
from goalwire.zenoh.protocol.primitives import ZenohProtocolError, decode_timestamp, ntp64
from goalwire.zenoh.protocol.publication import FLOOD, SMALL, Publication
from goalwire.zenoh.protocol.stamps import PAUSE_NS, Stamps

ATTACHMENT = bytes(33)
ZID = bytes(range(1, 17))


class Flood:
    """A publication whose link holds back, and what the other side gets of it."""

    def __init__(self, *, holds_back: bool = True) -> None:
        self.one, self.other = Session(ZID), Session(b'\xa1\xa2')
        self.one.holds_back = holds_back
        self.cable = Cable(self.one, self.other).start()
        self.samples: list[Sample] = []
        self.other.declare_subscriber('k', self.samples.append)
        self.cable.carry()
        self.publication = Publication(self.one, 'k')
        self.link, self.wire = self.cable.links[0], self.cable.wires[0]
        self.sent = 0

    def put(self, count: int = 1, size: int = 8) -> None:
        for _ in range(count):
            self.publication.put(self.sent.to_bytes(8, 'little').ljust(size, b'.'), ATTACHMENT)
            self.sent += 1

    def numbers(self) -> list[int]:
        """Carry all that was written, and return the numbers of what has come by now."""
        self.cable.carry()
        assert self.cable.ends == [None, None]
        return [int.from_bytes(bytes(each.payload or b'')[:8], 'little') for each in self.samples]


@pytest.fixture
def flood() -> Flood:
    """One that has begun: what is put next is held back."""
    flood = Flood()
    flood.put(FLOOD + 1)
    assert flood.numbers() == list(range(FLOOD + 1))
    return flood


# ---- what waits shares frames


def frames(queue: SendQueue) -> Iterator[bytes]:
    """Take everything out of a queue; yield it batch by batch."""
    data = bytearray()
    while queue:
        some = b''.join(bytes(each) for each in queue.next_buffers(64))
        queue.note_written(len(some))
        data += some
    while data:
        size = int.from_bytes(data[:2], 'little')
        yield bytes(data[2 : 2 + size])
        del data[: 2 + size]


def test_what_joins_a_waiting_frame_goes_out_in_it() -> None:
    queue = SendQueue()
    queue.begin(DATA_CHANNEL, b'h1', b'first')
    frame = queue.open[DATA_CHANNEL]
    assert frame is not None
    frame.parts.append(b'second')
    frame.size += 6
    queue.size += 6
    queue.begin(channel_of(1), b'h0', b'urgent')
    assert list(frames(queue)) == [b'h0urgent', b'h1firstsecond']
    assert queue.open[DATA_CHANNEL] is None


@pytest.mark.parametrize('reliable', [True, False])
def test_nothing_joins_a_frame_that_another_batch_stands_behind(reliable: bool) -> None:
    queue = SendQueue()
    queue.begin(channel_of(5, reliable=reliable), b'h1', b'first')
    queue.add(5, (b'\5\0piece',))
    assert queue.open[channel_of(5, reliable=reliable)] is None


def test_where_the_socket_is_full_messages_share_frames() -> None:
    flood = Flood(holds_back=False)
    flood.wire.room = 0
    flood.put(1000, size=100)
    assert flood.link.outgoing.queue.size > 100_000
    flood.wire.room = None
    flood.wire.writes = 0
    assert flood.link.outgoing.flush()
    assert flood.wire.writes == 1
    first = 2 + int.from_bytes(flood.wire.data[:2], 'little')  # it was put when nothing waited yet
    second = int.from_bytes(flood.wire.data[first : first + 2], 'little')
    assert second > 60_000
    assert flood.numbers() == list(range(1000))


def test_frames_grow_no_larger_than_the_other_side_takes() -> None:
    one, other = Session(ZID, batch_size=1000), Session(b'\xa1')
    cable = Cable(one, other).start()
    samples: list[Sample] = []
    other.declare_subscriber('k', samples.append)
    cable.carry()
    cable.wires[0].room = 0
    publication = Publication(one, 'k')
    for size in [10, 900, 300, 2000, 10] * 20:
        publication.put(bytes(size), ATTACHMENT)
    cable.wires[0].room = None
    cable.links[0].outgoing.flush()
    cable.carry()
    assert cable.ends == [None, None]
    assert [len(sample.payload or b'') for sample in samples] == [10, 900, 300, 2000, 10] * 20


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 3), st.sampled_from([1, 50, 3000, 70_000])), max_size=60),
    st.lists(st.integers(0, 200_000), max_size=20),
)
def test_each_channel_keeps_its_order_however_the_socket_takes_it(
    messages: list[tuple[int, int]], rooms: list[int]
) -> None:
    one, other = Session(ZID), Session(b'\xa1')
    one.holds_back = True
    cable = Cable(one, other).start()
    samples: list[Sample] = []
    other.declare_subscriber('k/*', samples.append)
    cable.carry()
    channels = [(5, True), (5, False), (2, True), (7, False)]
    publications = [
        Publication(one, f'k/{at}', priority=priority, reliable=reliable)
        for at, (priority, reliable) in enumerate(channels)
    ]
    one.stamps.burst = FLOOD + 1
    wanted: dict[str, list[bytes]] = {}
    left = iter(rooms)
    for number, (at, size) in enumerate(messages):
        cable.wires[0].room = next(left, None)
        payload = number.to_bytes(4, 'little') * (size // 4 + 1)
        publications[at].put(payload, ATTACHMENT)
        wanted.setdefault(f'k/{at}', []).append(payload)
    cable.wires[0].room = None
    cable.links[0].outgoing.release()
    cable.links[0].outgoing.flush()
    cable.carry()
    assert cable.ends == [None, None]
    came: dict[str, list[bytes]] = {}
    for sample in samples:
        came.setdefault(sample.key, []).append(bytes(sample.payload or b''))
    assert came == wanted


# ---- what is held back


def test_few_messages_in_a_row_are_never_held_back() -> None:
    flood = Flood()
    for _ in range(5):
        flood.put(20)
        assert flood.numbers() == list(range(flood.sent))
        flood.one.time.now += 1
    assert flood.wire.held == 0


def test_one_that_cannot_hold_back_does_not() -> None:
    flood = Flood(holds_back=False)
    flood.put(200)
    assert flood.numbers() == list(range(200))


def test_in_a_flood_messages_wait_and_go_out_together(flood: Flood) -> None:
    flood.wire.writes = flood.wire.held = 0
    flood.put(10)
    assert (flood.wire.writes, flood.wire.held) == (0, 1)
    flood.link.outgoing.release()
    assert flood.wire.writes == 1
    assert flood.numbers() == list(range(flood.sent))
    flood.link.outgoing.release()
    assert flood.wire.writes == 1


def test_no_more_than_a_few_kilobytes_are_held_back(flood: Flood) -> None:
    flood.wire.writes = 0
    flood.put(1000, size=100)
    assert flood.link.outgoing.queue.size < HELD_SIZE
    assert 10 < flood.wire.writes < 40
    flood.link.outgoing.release()
    assert flood.numbers() == list(range(flood.sent))


@pytest.mark.parametrize('size', [SMALL, LARGE])
def test_a_larger_message_takes_what_is_held_back_with_it(flood: Flood, size: int) -> None:
    flood.put(3)
    flood.put(1, size=size)
    assert flood.numbers() == list(range(flood.sent))
    assert not flood.link.outgoing.is_held


def test_what_is_declared_and_what_is_asked_is_held_up_by_nothing(flood: Flood) -> None:
    tokens: list[Sample] = []
    flood.other.watch_tokens('t', tokens.append, history=True)
    flood.put(3)
    flood.one.declare_token('t')
    assert flood.numbers() == list(range(flood.sent))
    assert len(tokens) == 1
    flood.put(3)
    flood.link.outgoing.tick()
    flood.link.outgoing.tick()
    flood.link.close(0)
    flood.cable.carry()
    assert [int.from_bytes(bytes(each.payload or b''), 'little') for each in flood.samples] == list(
        range(flood.sent)
    )


def test_what_is_held_back_while_the_socket_is_full_waits_for_it(flood: Flood) -> None:
    flood.put(3)
    flood.wire.room = 5
    wanted = flood.wire.wants_room
    flood.link.outgoing.release()
    assert flood.wire.wants_room == wanted + 1
    assert not flood.link.outgoing.is_held
    flood.put(300, size=100)
    flood.wire.room = None
    assert flood.link.outgoing.flush()
    assert flood.numbers() == list(range(flood.sent))


def test_an_expression_is_taken_back_behind_what_is_held_back(flood: Flood) -> None:
    flood.put(3)
    flood.publication.close()
    flood.link.outgoing.release()
    assert flood.numbers() == list(range(flood.sent))


# ---- stamps


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(-(10**9), 10**9) | st.integers(0, 5000), min_size=1, max_size=200))
def test_stamps_grow_and_tell_the_time_where_the_clock_does(steps: list[int]) -> None:
    now = [10**18]
    stamps = Stamps(ZID, lambda: now[0])
    last = 0
    for step in steps:
        now[0] += step
        stamp = decode_timestamp(stamps.next())
        assert stamp.zid == ZID
        assert stamp.time > last
        if ntp64(now[0]) > last:
            assert 0 <= ntp64(now[0]) - stamp.time < (10 << 32) // 1_000_000
        last = stamp.time


def test_stamps_grow_though_the_clock_stands_still() -> None:
    stamps = Stamps(ZID, lambda: 10**18 + 62_499_999)
    times = [decode_timestamp(stamps.next()).time for _ in range(40_000)]
    assert times == sorted(set(times))


def test_a_burst_is_counted_and_a_pause_ends_most_of_it() -> None:
    now = [10**18]
    stamps = Stamps(ZID, lambda: now[0])
    for _ in range(1000):
        now[0] += PAUSE_NS - 1
        stamps.next()
    assert stamps.burst == 256
    now[0] += PAUSE_NS
    stamps.next()
    assert stamps.burst == 64


# ---- the form of messages


def link_of(other: Session) -> Link:
    """The one link of a session."""
    (link,) = other.links
    return link


@settings(max_examples=80, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 2),
            st.integers(0, 70_000) | st.sampled_from([0, 1, 127, 128, 16384]),
            st.sampled_from([None, b'', b'a', ATTACHMENT, bytes(200)]),
            st.booleans(),
        ),
        max_size=40,
    )
)
def test_messages_are_read_alike_by_their_form_and_without(
    messages: list[tuple[int, int, bytes | None, bool]],
) -> None:
    sides: list[list[Sample]] = []
    for zid in (ZID, b'\x0b'):  # forms of a session with a short id are not remembered
        one, other = Session(zid), Session(b'\xa1\xa2')
        one.holds_back = True
        one.stamps.burst = FLOOD + 1
        cable = Cable(one, other).start()
        samples: list[Sample] = []
        other.declare_subscriber('**', samples.append)
        cable.carry()
        publications = [
            Publication(one, key, droppable=droppable)
            for key, droppable in (('a', True), ('b', False), ('a', False))
        ]
        for number, (at, size, attachment, goes) in enumerate(messages):
            publications[at].put(number.to_bytes(4, 'little') * (size // 4), attachment)
            if goes:
                cable.links[0].outgoing.release()
        cable.links[0].outgoing.release()
        cable.carry()
        assert cable.ends == [None, None]
        sides.append([(each.key, bytes(each.payload or b''), each.attachment) for each in samples])  # type: ignore[misc]
        assert len(samples) == len(messages)
        stamps = [each.timestamp for each in samples]
        assert all(stamp is not None and stamp.zid == zid for stamp in stamps)
    assert sides[0] == sides[1]


def test_a_form_is_remembered_and_forgotten_with_who_gets_what(flood: Flood) -> None:
    link = link_of(flood.other)
    assert len(link.push_forms) == 1
    late: list[Sample] = []
    number = flood.other.declare_subscriber('k', late.append)
    assert link.push_forms == {}
    flood.put(3)
    flood.link.outgoing.release()
    assert flood.numbers() == list(range(flood.sent))
    assert len(late) == 3
    flood.other.undeclare(number)
    flood.put(3)
    flood.link.outgoing.release()
    assert flood.numbers() == list(range(flood.sent))
    assert len(late) == 3


def test_one_that_raises_keeps_the_others_from_nothing(flood: Flood) -> None:
    def fail(_: Sample) -> None:
        raise IndexError('mine')

    flood.other.declare_subscriber('k', fail)
    flood.put(5)
    flood.link.outgoing.release()
    assert flood.numbers() == list(range(flood.sent))
    assert len(flood.other.failures) == 5


@pytest.mark.parametrize('cut', range(1, 60))
def test_a_message_of_a_known_form_that_is_cut_off_ends_its_link(flood: Flood, cut: int) -> None:
    flood.put(2)
    flood.link.outgoing.release()
    batch = bytearray(flood.wire.take())
    size = int.from_bytes(batch[:2], 'little')
    assert size == len(batch) - 2
    batch[:2] = (size - cut).to_bytes(2, 'little')
    link = link_of(flood.other)
    with pytest.raises(ZenohProtocolError):
        link.frames.receive(bytes(batch[: len(batch) - cut]))
    assert len(flood.samples) == FLOOD + 2


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_message_of_a_known_form_with_other_bytes_breaks_nothing_but_its_link(data: st.DataObject) -> None:
    flood = Flood()
    flood.put(FLOOD + 1)
    flood.numbers()
    flood.put(2)
    flood.link.outgoing.release()
    batch = bytearray(flood.wire.take())
    for _ in range(data.draw(st.integers(1, 3))):
        batch[data.draw(st.integers(7, len(batch) - 1))] = data.draw(st.integers(0, 255))
    try:
        link_of(flood.other).frames.receive(bytes(batch))
    except (ZenohProtocolError, ClosedByPeerError):
        return
    for sample in flood.samples:
        assert sample.payload is None or len(sample.payload) < len(batch)
