"""Between two users, and for a user who may lock little memory, every message arrives whole.

goalwire locks no memory. eclipse-zenoh locks the segments that it reads, and may drop without a word what
comes in those that it could not lock. With less than 2 MiB to lock it opens no session that shares memory.
"""

from __future__ import annotations

import os
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from random import Random
from typing import TypeAlias

import pytest
from helpers.patience import PATIENCE, wait_for
from helpers.processes import Program
from helpers.zenoh_memory import WITH_ALL, WITH_OWN, segments_of, shares
from helpers.zenoh_sides import Ours, Side, address

from goalwire.zenoh.io.shared_memory.reader import find_atomics
from goalwire.zenoh.protocol.bodies import Sample

if os.name != 'posix' or os.geteuid():
    pytest.skip('only root can become somebody else', allow_module_level=True)

PROGRAMS = Path(__file__).parent / 'programs'
OURS, THEIRS = PROGRAMS / 'own_side.py', PROGRAMS / 'eclipse_side.py'
KEY, COUNT = 'test/shared', 60
LITTLE = 64
"""KiB that a user may lock in memory."""
SIZES = (10, 3000, 70_000, 200_000, 1_000_000)
ALL_WHOLE = f'^received {COUNT} torn 0 gaps 0$'
THEIRS_WHOLE = rf'^received {COUNT} complete True torn 0 shared (\w+)$'

needs_atomics = pytest.mark.skipif(find_atomics() is None, reason='the package atomicshm is not installed')
Run: TypeAlias = Callable[..., Program]


@pytest.fixture
def run() -> Iterator[Run]:
    """A function that runs one side of a test as the user `nobody`."""
    with ExitStack() as stack:
        yield lambda program, *arguments: stack.enter_context(Program(program, *map(str, arguments)))


def publish(ours: Ours) -> None:
    """Send numbered messages with checksums, once somebody has subscribed."""
    wait_for(
        lambda: any(link.peer.subscribers.has_meeting(KEY) for link in ours.protocol.links), 'the subscriber'
    )
    random = Random(COUNT)
    for number in range(COUNT):
        body = random.randbytes(random.choice(SIZES))
        ours.put(KEY, number.to_bytes(4, 'little') + zlib.crc32(body).to_bytes(4, 'little') + body)


def take_all(ours: Ours) -> threading.Event:
    """Set the event when all messages have come whole and in order."""
    numbers: list[int] = []
    ended = threading.Event()

    def take(sample: Sample) -> None:
        data = bytes(sample.payload or b'')
        if zlib.crc32(data[8:]) == int.from_bytes(data[4:8], 'little'):
            numbers.append(int.from_bytes(data[:4], 'little'))
        if numbers == list(range(COUNT)):
            ended.set()

    ours.protocol.declare_subscriber(KEY, take)
    return ended


def test_another_users_program_gets_bytes(sides: list[Side], run: Run) -> None:
    where = address()
    reader = run(OURS, 'subscriber', where, COUNT, LITTLE)
    reader.expect('ready')
    ours = Ours('peer', connect=(where,), memory=WITH_OWN)
    sides.append(ours)
    publish(ours)
    reader.expect(ALL_WHOLE)
    assert shares(ours) == [False]


def test_from_another_users_program_come_bytes(sides: list[Side], run: Run) -> None:
    where = address()
    ours = Ours('peer', listen=(where,), memory=WITH_OWN)
    sides.append(ours)
    ended = take_all(ours)
    writer = run(OURS, 'publisher', where, COUNT, LITTLE)
    assert ended.wait(PATIENCE)
    assert shares(ours) == [False]
    writer.expect('sent')


def test_one_who_may_lock_little_shares_with_its_own_kind(run: Run) -> None:
    where = address()
    reader = run(OURS, 'subscriber', where, COUNT, LITTLE)
    reader.expect('ready')
    writer = run(OURS, 'publisher', where, COUNT, LITTLE)
    reader.expect(ALL_WHOLE)
    assert len(segments_of(writer.pid)) > 1, 'the first segment is the one of the handshake'


@needs_atomics
@pytest.mark.parametrize(('lockable', 'shared'), [(2048, False), (8192, True)])
def test_eclipses_reader_gets_bytes_if_it_cannot_lock_the_writers_segment(
    run: Run, lockable: int, shared: bool
) -> None:
    where = address()
    reader = run(THEIRS, 'subscriber', 'listen', where, COUNT, lockable)
    reader.expect('ready')
    run(OURS, 'publisher', where, COUNT, LITTLE, 'all')
    assert reader.expect(THEIRS_WHOLE)[1] == str(shared)


@needs_atomics
def test_eclipses_reader_of_another_user_loses_nothing(sides: list[Side], run: Run) -> None:
    where = address()
    reader = run(THEIRS, 'subscriber', 'listen', where, COUNT, 8192)
    reader.expect('ready')
    ours = Ours('peer', connect=(where,), memory=WITH_ALL)
    sides.append(ours)
    publish(ours)
    reader.expect(THEIRS_WHOLE)
