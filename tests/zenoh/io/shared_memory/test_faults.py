"""One side goes on, loses nothing, and gets its memory back, whatever happens to the other."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from random import Random
from typing import TypeAlias

import pytest
from helpers.patience import PATIENCE, wait_for
from helpers.processes import Program
from helpers.zenoh_memory import WITH_OWN, OpenPair, lent, segments_of, shares
from helpers.zenoh_sides import Ours, Side, address

from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.io.shared_memory import layout
from goalwire.zenoh.io.shared_memory.segments import ForeignSegment, sweep
from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.publication import Publication

PROGRAM = Path(__file__).parent / 'programs' / 'own_side.py'
KEY = 'test/shared'
SMALL_POOL = MemorySettings(with_own=True, least=1024, pool_size=8 << 20)
Run: TypeAlias = Callable[..., Program]


@pytest.fixture
def run() -> Iterator[Run]:
    """A function that runs one side of a test."""
    with ExitStack() as stack:
        yield lambda role, where, most: stack.enter_context(Program(PROGRAM, role, where, str(most)))


def publish(ours: Ours, payloads: Iterator[bytes]) -> None:
    """Publish on a publication that drops what finds no room, as a camera's does."""
    publication = Publication(ours.protocol, KEY, droppable=True)
    for payload in payloads:
        publication.put(payload)
    publication.close()


def share_one(ours: Ours) -> None:
    """Publish until a message has gone through memory: the reader has shown that it reads it."""

    def has_shared() -> bool:
        publish(ours, iter([bytes(100_000)]))
        pool = ours.session._memory.pool
        return pool is not None and sum(pool._generations) > 1

    wait_for(has_shared, 'a message through memory')


def read_by(ours: Ours) -> bool:
    return any(link.peer.subscribers.has_meeting(KEY) for link in ours.protocol.links)


def connect_to(sides: list[Side], where: str, memory: MemorySettings = WITH_OWN) -> Ours:
    ours = Ours('peer', connect=(where,), memory=memory)
    sides.append(ours)
    wait_for(lambda: read_by(ours), 'the subscriber')
    return ours


def test_what_a_killed_reader_held_comes_back(sides: list[Side], run: Run) -> None:
    where = address()
    reader = run('subscriber', where, 0)
    reader.expect('ready')
    ours = connect_to(sides, where)
    share_one(ours)
    reader.expect('first')
    reader.send_signal(signal.SIGSTOP)
    publish(ours, iter([bytes(300_000)] * 20))
    assert lent(ours) > 0
    reader.kill()
    wait_for(lambda: not ours.protocol.links, 'the end of the link')
    pool = ours.session._memory.pool
    assert pool is not None
    for each in pool._readers:
        each.given_up_at = -1e9  # the grace is over
    pool._section.run(pool._collect_orphans)
    assert lent(ours) == 0


def test_a_reader_that_stops_holds_its_share_and_publishing_goes_on(sides: list[Side], run: Run) -> None:
    where = address()
    stopped = run('subscriber', where, 0)
    stopped.expect('ready')
    ours = connect_to(sides, where, SMALL_POOL)
    share_one(ours)
    stopped.expect('first')
    heard = ours.subscribe(KEY)
    stopped.send_signal(signal.SIGSTOP)
    publish(ours, iter([bytes(200_000)] * 200))
    pool = ours.session._memory.pool
    assert pool is not None
    assert 0 < sum(each.size for each in pool._readers) <= pool.share
    assert len(heard.wait(200)) == 200
    stopped.send_signal(signal.SIGCONT)
    wait_for(lambda: not lent(ours), 'what the reader held')


def test_what_a_killed_writer_leaves_is_swept_by_the_next(sides: list[Side], run: Run) -> None:
    where = address()
    ours = Ours('peer', listen=(where,), memory=WITH_OWN)
    sides.append(ours)
    heard = ours.subscribe(KEY)
    writer = run('publisher', where, 0)
    heard.wait(100)
    left = segments_of(writer.pid) - segments_of(os.getpid())
    writer.kill()
    writer.wait()
    sweep()
    assert not [path for path in left if path.exists()]


def test_nonsense_in_the_writers_segments_ends_the_link_and_then_bytes_come(open_pair: OpenPair) -> None:
    one, other = open_pair()
    heard = other.subscribe('a')
    watch = one.watch('ready/a')
    other.token('ready/a')
    watch.wait(1)
    for at in range(20):
        one.put('a', bytes([at]) * 100_000)
    heard.wait(20)
    pool = one.session._memory.pool
    assert pool is not None
    assert pool._metadata is not None
    headers = pool._metadata.map
    lend = pool.lend

    def spoil(chunk, lent):  # type: ignore[no-untyped-def]
        pointer = lend(chunk, lent)
        if pointer is not None:
            head = list(layout.HEADER.unpack_from(headers, pointer.header * layout.HEADER.size))
            head[5] = 0xFFFF_FFF0  # an offset behind the segment's end
            layout.HEADER.pack_into(headers, pointer.header * layout.HEADER.size, *head)
        return pointer

    pool.lend = spoil  # type: ignore[method-assign]
    one.put('a', bytes(100_000))
    wait_for(lambda: shares(other) == [False], 'a link that carries bytes')
    wait_for(lambda: shares(one) == [False] and other.id in one.links(), 'the other end of it')
    for at in range(5):
        one.put('a', bytes([at]) * 100_000)
    assert [payload and payload[0] for _, payload in heard.wait(25)[-5:]] == list(range(5))


def test_random_bytes_in_all_segments_end_no_process(sides: list[Side], run: Run) -> None:
    """A hostile process of the same user writes into all segments of both sides while they talk."""
    where = address()
    ours = Ours('peer', listen=(where,), memory=SMALL_POOL)
    sides.append(ours)
    numbers: list[int] = []

    def take(sample: Sample) -> None:
        numbers.append(len(sample.payload or b''))

    ours.protocol.declare_subscriber(KEY, take)
    writer = run('publisher', where, 0)
    writer.expect('ready')
    wait_for(lambda: len(numbers) > 20, 'messages')
    random = Random(4)
    for _ in range(40):
        for path in segments_of(writer.pid) | segments_of(os.getpid()):
            try:
                segment = ForeignSegment(int(path.name.partition('.')[0]), writable=True)
            except OSError:
                continue
            size = min(segment.size, 1 << 16)
            os.pwrite(segment.fd, random.randbytes(size), random.choice((0, max(0, segment.size - size))))
            segment.close()
    count = len(numbers)
    wait_for(lambda: len(numbers) > count + 50, 'messages after the nonsense')
    assert max(numbers) <= 1_000_008, 'foreign memory was read'


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize('victim', ['subscriber', 'publisher'])
def test_two_hundred_kills_of_either_side_leave_nothing_and_tear_nothing(
    sides: list[Side], run: Run, victim: str
) -> None:
    random = Random(9)
    where = address()
    if victim == 'publisher':
        ours = Ours('peer', listen=(where,), memory=SMALL_POOL)
        sides.append(ours)
        heard = ours.subscribe(KEY)
    else:
        with Program(PROGRAM, 'subscriber', where, '0') as first:
            first.expect('ready')
            ours = connect_to(sides, where, SMALL_POOL)
            first.kill()
    left: set[Path] = set()
    for _ in range(200):
        with Program(PROGRAM, victim, where, '0') as killed:
            killed.expect('ready')
            if victim == 'publisher':
                known = len(heard.samples)
                heard.wait(known + 1 + random.randrange(30))
                left |= segments_of(killed.pid)
                killed.kill()
                heard.samples.clear()
            else:
                wait_for(lambda: read_by(ours), 'the subscriber')
                stop = threading.Event()
                thread = threading.Thread(target=publish, args=(ours, _until(stop, random)))
                thread.start()
                killed.expect('first')
                left |= segments_of(killed.pid)
                killed.kill()
                stop.set()
                thread.join(PATIENCE)
                assert not thread.is_alive(), 'publishing hangs'
    wait_for(lambda: not ours.protocol.links, 'the end of the last link')
    sweep()
    assert not [path for path in left - segments_of(os.getpid()) if path.exists()]


def _until(stop: threading.Event, random: Random) -> Iterator[bytes]:
    while not stop.is_set():
        yield random.randbytes(random.choice((3000, 100_000, 500_000)))


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(600)
def test_ten_thousand_messages_of_random_sizes_all_arrive_whole(run: Run) -> None:
    where = address()
    reader = run('subscriber', where, 10_000)
    reader.expect('ready')
    writer = run('publisher', where, 10_000)
    writer.expect('sent', 300)
    reader.expect('received 10000 torn 0 gaps 0', 300)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.skipif(os.geteuid() != 0 or not shutil.which('unshare'), reason='needs root and unshare')
def test_a_full_dev_shm_means_bytes() -> None:
    """Both sides live where /dev/shm has 2 MiB: less than the first segment."""
    where = address()
    script = f"""
    mount -t tmpfs -o size=2m none /dev/shm || exit 3
    {sys.executable} {PROGRAM} subscriber {where} 500 </dev/null >out.reader 2>&1 &
    until grep -q ready out.reader; do sleep 0.05; done
    {sys.executable} {PROGRAM} publisher {where} 500 </dev/null 2>&1
    wait
    cat out.reader
    ls /dev/shm | wc -l
    """
    folder = Path(os.environ.get('TMPDIR', '/var/tmp')) / f'goalwire-full-{os.getpid()}'
    folder.mkdir()
    try:
        done = subprocess.run(
            ['unshare', '--mount', 'sh', '-c', script],
            cwd=folder,
            capture_output=True,
            check=False,
            text=True,
            timeout=120,
        )
    finally:
        shutil.rmtree(folder)
    assert 'received 500 torn 0 gaps 0' in done.stdout, done.stdout + done.stderr
    assert 'No space left on device' in done.stdout
    assert done.stdout.split()[-1] == '0'
