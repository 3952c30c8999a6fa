"""Payloads go through shared memory between sessions of goalwire's, and nobody loses one."""

from __future__ import annotations

import os
import sys
from array import array
from random import Random

import pytest
from helpers.patience import wait_for
from helpers.zenoh_memory import WITH_OWN, OpenPair, lent, segments_of, shares
from helpers.zenoh_sides import Ours, Side, address

from goalwire.errors import EncodeError
from goalwire.payload_parts import Parts
from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.protocol.publication import Publication

OFF = MemorySettings()
SIZES = (10, 1024, 5000, 65_535, 65_536, 300_000, 1_000_000)


def exchange(sender: Side, receiver: Side, count: int, sizes: tuple[int, ...] = SIZES) -> None:
    """Send messages of random sizes and contents, and see that each arrives once, as it was, in order."""
    heard = receiver.subscribe('a/*')
    watch = sender.watch('ready/**')
    ready = receiver.token(f'ready/{sender.id}')
    watch.wait(1)
    random = Random(count)
    sent = [random.randbytes(random.choice(sizes)) for _ in range(count)]
    for payload in sent:
        sender.put('a/b', payload)
    came = [payload for _, payload in heard.wait(count)]
    assert [len(each or b'') for each in came] == [len(each) for each in sent]
    assert came == sent
    ready()


def test_messages_of_all_sizes_arrive_both_ways_and_every_chunk_comes_back(open_pair: OpenPair) -> None:
    one, other = open_pair()
    assert shares(one) == shares(other) == [True]
    for sender, receiver in ((one, other), (other, one)):
        exchange(sender, receiver, 200)
        pool = sender.session._memory.pool
        assert pool is not None
        assert pool._generations, 'nothing went through shared memory'
        wait_for(lambda: not lent(sender), 'every chunk to come back')  # noqa: B023 - it is waited for here


def test_a_pool_that_is_full_means_bytes(open_pair: OpenPair) -> None:
    one, other = open_pair(MemorySettings(with_own=True, least=1024, pool_size=300_000))
    exchange(one, other, 100, (200_000, 250_000, 1_000_000))


@pytest.mark.parametrize('settings', [(WITH_OWN, OFF), (OFF, WITH_OWN), (OFF, OFF)])
def test_a_side_that_shares_no_memory_gets_bytes(
    open_pair: OpenPair, settings: tuple[MemorySettings, MemorySettings]
) -> None:
    one, other = open_pair(*settings)
    assert shares(one) == shares(other) == [False]
    exchange(one, other, 20)


def test_several_readers_get_one_chunk(open_pair: OpenPair, sides: list[Side]) -> None:
    one, other = open_pair()
    third = Ours('peer', connect=one.session._settings.listen, memory=WITH_OWN)
    sides.append(third)
    wait_for(lambda: third.id in one.links(), 'the link')
    heard = [other.subscribe('a'), third.subscribe('a')]
    one.watch('ready/**')
    for reader in (other, third):
        reader.token(f'ready/{reader.id}')
    wait_for(lambda: len(one.present('ready/**')) == 2, 'both readers')
    for at in range(30):
        one.put('a', bytes([at]) * 100_000)
    for each in heard:
        assert [payload and payload[0] for _, payload in each.wait(30)] == list(range(30))
    wait_for(lambda: not lent(one), 'every chunk to come back')


def test_segments_are_gone_when_their_session_is_closed() -> None:
    where = address()
    one = Ours('peer', listen=(where,), memory=WITH_OWN)
    other = Ours('peer', connect=(where,), memory=WITH_OWN)
    exchange(one, other, 5)
    made = segments_of(os.getpid())
    assert len(made) >= 4
    assert {path.stat().st_mode & 0o777 for path in made} == {0o600}
    other.close()
    one.close()
    assert not [path for path in made if path.exists()]


def test_messages_that_a_session_sent_before_its_end_arrive(open_pair: OpenPair) -> None:
    one, other = open_pair()
    exchange(one, other, 5)
    heard = other.subscribe('last')
    watch = one.watch('ready/last')
    other.token('ready/last')
    watch.wait(1)
    sent = [os.urandom(200_000) for _ in range(10)]
    for payload in sent:
        one.put('last', payload)
    one.close()
    assert [payload for _, payload in heard.wait(10)] == sent


def test_a_view_stays_as_it_is_while_it_is_held_and_then_gives_its_chunk_back(open_pair: OpenPair) -> None:
    one, other = open_pair()
    exchange(one, other, 5)
    views: list[memoryview] = []

    def keep(sample: object) -> None:
        payload = sample.payload  # type: ignore[attr-defined]
        if isinstance(payload, memoryview) and payload.readonly:
            views.append(payload)

    other.protocol.declare_subscriber('view', keep, takes_views=True)
    watch = one.watch('ready/view')
    other.token('ready/view')
    watch.wait(1)
    wait_for(lambda: not lent(one), 'the chunks from before')
    one.put('view', b'first' * 20_000)
    wait_for(lambda: len(views) == 1, 'the view')
    assert lent(one) == 1
    for _ in range(50):
        one.put('other', bytes(100_000))
    exchange(one, other, 50, (100_000,))
    one.close()
    assert views[0] == b'first' * 20_000
    with pytest.raises(TypeError):
        views[0][0] = 1
    views.clear()


def test_a_view_that_is_let_go_gives_its_chunk_back(open_pair: OpenPair) -> None:
    one, other = open_pair()
    exchange(one, other, 5)
    views: list[object] = []
    other.protocol.declare_subscriber('view', lambda sample: views.append(sample.payload), takes_views=True)
    watch = one.watch('ready/view')
    other.token('ready/view')
    watch.wait(1)
    one.put('view', bytes(100_000))
    wait_for(lambda: views, 'the view')
    wait_for(lambda: lent(one) == 1, 'the chunks from before')
    views.clear()
    if sys.version_info >= (3, 13) and not sys._is_gil_enabled():
        one.put('view', b'')  # without a GIL the thread that has made the view frees it, when it runs next
        wait_for(lambda: lent(one) == 0, 'the chunk')
    assert lent(one) == 0


def test_more_views_than_there_may_be_are_copies(open_pair: OpenPair) -> None:
    one, other = open_pair(MemorySettings(with_own=True, least=1024, pool_size=64 << 20))
    exchange(one, other, 5)
    held: list[bytes | memoryview | None] = []
    other.protocol.declare_subscriber('view', lambda sample: held.append(sample.payload), takes_views=True)
    watch = one.watch('ready/view')
    other.token('ready/view')
    watch.wait(1)
    for at in range(100):
        one.put('view', bytes([at]) * 2000)
    wait_for(lambda: len(held) == 100, 'all')
    assert [bytes(each or b'') for each in held] == [bytes([at]) * 2000 for at in range(100)]
    assert lent(one) <= 64
    held.clear()


def test_a_view_that_outlives_its_session_keeps_its_content(open_pair: OpenPair) -> None:
    one, other = open_pair()
    exchange(one, other, 5)
    views: list[memoryview] = []
    other.protocol.declare_subscriber('view', lambda sample: views.append(sample.payload), takes_views=True)  # type: ignore[arg-type]
    watch = one.watch('ready/view')
    other.token('ready/view')
    watch.wait(1)
    one.put('view', b'kept' * 30_000)
    wait_for(lambda: views, 'the view')
    other.close()
    pool = one.session._memory.pool
    assert pool is not None
    pool._readers[0].given_up_at = -1e9  # long ago: no grace is left
    pool._section.run(pool._collect_orphans)
    assert lent(one) == 1, 'the chunk was taken back while its view is held'
    assert views[0] == b'kept' * 30_000
    views.clear()
    assert lent(one) == 0


def put_parts(side: Ours, parts: Parts) -> None:
    """Publish a payload in parts on the key 'parts'."""
    publication = Publication(side.protocol, 'parts')
    publication.put(parts)
    publication.close()


@pytest.mark.parametrize('settings', [WITH_OWN, OFF])
def test_a_message_in_parts_is_copied_once_into_shared_memory(
    open_pair: OpenPair, settings: MemorySettings
) -> None:
    one, other = open_pair(settings, settings)
    exchange(one, other, 20)  # the first ones show that the reader can open the segments
    heard = other.subscribe('parts')
    watch = one.watch('ready/parts')
    other.token('ready/parts')
    watch.wait(1)
    numbers = array('B', os.urandom(200_000))
    parts = Parts([b'head', numbers], 200_004, 'some_msgs/msg/Numbers')
    put_parts(one, parts)
    numbers[0] ^= 255
    ((_, payload),) = heard.wait(1)
    numbers[0] ^= 255
    assert payload == b'head' + numbers.tobytes()
    assert (parts._joined is None) == (settings is WITH_OWN)


def test_a_message_that_another_thread_changes_keeps_no_chunk(open_pair: OpenPair) -> None:
    one, other = open_pair()
    exchange(one, other, 20)
    wait_for(lambda: not lent(one), 'every chunk to come back')
    heard = other.subscribe('parts')
    watch = one.watch('ready/parts')
    other.token('ready/parts')
    watch.wait(1)
    numbers = array('B', bytes(100_000))
    for _ in range(3):
        with pytest.raises(EncodeError, match='changed its length'):
            put_parts(one, Parts([numbers], len(numbers) - 1, 'some_msgs/msg/Numbers'))
    gone = memoryview(bytes(100_000))
    parts = Parts([gone], len(gone), 'some_msgs/msg/Numbers')
    gone.release()
    with pytest.raises(ValueError, match='released'):
        put_parts(one, parts)
    assert not lent(one)
    put_parts(one, Parts([numbers], len(numbers), 'some_msgs/msg/Numbers'))
    assert [payload for _, payload in heard.wait(1)] == [numbers.tobytes()]
