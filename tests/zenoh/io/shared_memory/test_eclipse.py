"""eclipse-zenoh and sessions of ours read each other's memory, of both generations, also through a router."""

from __future__ import annotations

import sys
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from random import Random
from typing import TypeAlias

import pytest
from helpers.environments import CannotInstall, kept_for_all
from helpers.patience import PATIENCE, wait_for
from helpers.processes import Program
from helpers.zenoh_memory import WITH_ALL, shares
from helpers.zenoh_sides import Ours, Side, address

from goalwire.zenoh.io.shared_memory.reader import MemoryReader, find_atomics
from goalwire.zenoh.protocol.bodies import Sample

THEIRS = Path(__file__).parent / 'programs' / 'eclipse_side.py'
HERE = Path(sys.executable)
SIZES = (10, 1000, 3000, 60_000, 200_000, 1_000_000)
GENERATIONS = (('1.6.2', '1.7.2', '1.9.0'), ('1.10.0', '1.10.2'))
"""Those before have no shared memory in their wheels; 1.8.0 has no wheel."""
ROUTES = [
    (version, router) for versions in GENERATIONS for version in versions for router in (None, *versions)
]
"""Versions of eclipse-zenoh, and the routers before them. Routers of 1.10 tear messages to clients of 1.6,
also those that came to them as bytes."""
KEY = 'test/shared'

needs_atomics = pytest.mark.skipif(find_atomics() is None, reason='the package atomicshm is not installed')
Run: TypeAlias = Callable[..., Program]


@pytest.fixture
def run() -> Iterator[Run]:
    """A function that runs eclipse-zenoh's side of a test, and waits until it is ready."""
    with ExitStack() as stack:

        def run_one(role: str, mode: str, where: str, count: int, python: Path = HERE) -> Program:
            program = stack.enter_context(Program(THEIRS, role, mode, where, str(count), python=python))
            program.expect('ready')
            return program

        yield run_one


@pytest.fixture
def python_with(pytestconfig: pytest.Config) -> Callable[[str], Path]:
    """A function that returns the interpreter of an environment with some version of eclipse-zenoh."""

    def find(version: str) -> Path:
        requirement = f'eclipse-zenoh=={version}'
        try:
            return kept_for_all(pytestconfig.cache, requirement).python
        except CannotInstall as error:
            pytest.skip(f'{requirement} cannot be installed here: {error}')

    return find


def numbered(count: int) -> Iterator[bytes]:
    """Messages with their number and checksum, as the program beside this reads them."""
    random = Random(count)
    for number in range(count):
        body = random.randbytes(random.choice(SIZES))
        yield number.to_bytes(4, 'little') + zlib.crc32(body).to_bytes(4, 'little') + body


def they_receive(ours: Ours, theirs: Program, count: int) -> None:
    """Publish, and see that they got each message whole and in its place, some of them shared."""
    wait_for(
        lambda: any(link.peer.subscribers.has_meeting(KEY) for link in ours.protocol.links),
        'their subscriber',
    )
    for payload in numbered(count):
        ours.put(KEY, payload)
    found = theirs.expect(r'received (\d+) complete (\w+) torn (\d+) shared (\w+)', 300)
    assert found.groups() == (str(count), 'True', '0', 'True')


def we_receive(ours: Ours, theirs: Program, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have them publish, and see that we got each message whole and in its place, some of them shared."""
    numbers: list[int] = []
    torn: list[int] = []
    shared: list[int] = []
    ended = threading.Event()
    follow = MemoryReader._follow

    def count_shared(*arguments: object, **options: object) -> object:
        shared.append(1)
        return follow(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(MemoryReader, '_follow', count_shared)
    wait_for(ours.links, 'the link')

    def take(sample: Sample) -> None:
        data = bytes(sample.payload or b'')
        number = int.from_bytes(data[:4], 'little')
        if zlib.crc32(data[8:]) != int.from_bytes(data[4:8], 'little'):
            torn.append(number)
        numbers.append(number)
        if number == count - 1:
            ended.set()

    ours.protocol.declare_subscriber(KEY, take)
    theirs.expect('sent', 300)
    assert ended.wait(PATIENCE), f'{len(numbers)} of {count} messages came'
    assert (len(numbers), torn, shared != []) == (count, [], True)
    assert numbers == list(range(count))


@needs_atomics
@pytest.mark.parametrize('they_listen', [False, True])
@pytest.mark.parametrize('role', ['subscriber', 'publisher'])
def test_each_reads_the_others_memory(
    sides: list[Side], run: Run, monkeypatch: pytest.MonkeyPatch, role: str, they_listen: bool
) -> None:
    where = address()
    if they_listen:
        theirs = run(role, 'listen', where, 60)
    listen, connect = ((), (where,)) if they_listen else ((where,), ())
    ours = Ours('peer', connect=connect, listen=listen, memory=WITH_ALL)
    sides.append(ours)
    if not they_listen:
        theirs = run(role, 'connect', where, 60)
    wait_for(lambda: shares(ours) == [True], 'a link with shared memory')
    if role == 'subscriber':
        they_receive(ours, theirs, 60)
    else:
        we_receive(ours, theirs, 60, monkeypatch)


@needs_atomics
@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize(('version', 'router'), ROUTES)
@pytest.mark.parametrize('role', ['subscriber', 'publisher'])
def test_ten_thousand_messages_of_each_version_directly_and_through_each_router(
    sides: list[Side],
    run: Run,
    python_with: Callable[[str], Path],
    monkeypatch: pytest.MonkeyPatch,
    role: str,
    version: str,
    router: str | None,
) -> None:
    where = address()
    if router is not None:
        run('router', 'listen', where, 0, python_with(router))
    listen, connect = ((where,), ()) if router is None else ((), (where,))
    ours = Ours('peer', connect=connect, listen=listen, memory=WITH_ALL)
    sides.append(ours)
    theirs = run(role, 'connect' if router is None else 'client', where, 10_000, python_with(version))
    wait_for(lambda: shares(ours) == [True], 'a link with shared memory')
    if role == 'subscriber':
        they_receive(ours, theirs, 10_000)
    else:
        we_receive(ours, theirs, 10_000, monkeypatch)
