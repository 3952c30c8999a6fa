"""A process with a context forks: what the child must not touch, and what it may do of its own.

Each program of `programs/` prints `good` or says what it saw. GOALWIRE_TEST_FORKS=50 runs each that often.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress

import pytest
from helpers.process_life import PROGRAMS, WIRES, world_on
from helpers.programs import Start, programs_in

from goalwire.transport.dds import NATIVE, choose_session

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != 'linux', reason='uses pidfd, and looks in /proc'),
    pytest.mark.timeout(400),
]

TIMES = int(os.environ.get('GOALWIRE_TEST_FORKS', '1'))


@pytest.fixture(params=['zenoh', 'dds'])
def start(request: pytest.FixtureRequest) -> Iterator[Start]:
    """A function that starts a program of this folder, on each wire."""
    with programs_in(world_on(request.param), PROGRAMS) as start:
        yield start


@pytest.mark.parametrize(
    'name',
    [
        'close_on_exec',
        'closed_session',
        'daemon',
        'exits_beside_a_coroutine',
        'pool',
        'preexec_fn',
        'shutdown_in_child',
        'terminate_at_once',
        'terminate_child',
    ],
)
def test_it_is_good(start: Start, name: str) -> None:
    for _ in range(TIMES):
        with start(name) as program:
            assert program.succeed(60).splitlines()[-1:] == ['good']


@pytest.mark.long
def test_children_forked_while_sockets_are_opened_have_none(start: Start) -> None:
    """Two threads open and close contexts meanwhile; one such moment: tests/concurrency/test_forks.py."""
    with start('forks_beside_opening', 300) as program:
        assert program.succeed(120).splitlines()[-1:] == ['good']


@pytest.mark.parametrize('session', WIRES)
def test_init_in_a_child_opens_a_context_of_its_own_or_says_why_not(session: str) -> None:
    """Neither eclipse-zenoh nor libddsc can start again in a child what it has started before."""
    can = session == 'zenoh' or (session == 'dds' and choose_session() == NATIVE)
    arguments = () if can else ('refused',)
    with programs_in(world_on(session), PROGRAMS) as start:
        for _ in range(TIMES):
            with start('init_in_child', *arguments) as program:
                assert program.succeed(60).splitlines()[-1:] == ['good']


@pytest.mark.parametrize('session', ['zenoh', 'eclipse'])
@pytest.mark.parametrize('is_killed', [False, True], ids=['ends', 'is killed'])
def test_a_child_of_the_rendezvous_keeps_nobody_apart(session: str, is_killed: bool) -> None:
    """The holder of the port goes and its child lives: another process takes the port, and all meet there."""
    for _ in range(TIMES):
        with programs_in(world_on(session), PROGRAMS) as start:
            holder = start('holds_and_forks')
            child = int(holder.expect('ready (.*)')[1])
            try:
                if is_killed:
                    holder.kill()
                    holder.wait()
                else:
                    holder.write_line('')
                    holder.wait()
                pair = [start('meets', 'one', 'other'), start('meets', 'other', 'one')]
                for each in pair:
                    each.expect('met')
                for each in pair:
                    each.write_line('')
                    each.succeed()
            finally:
                with suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
