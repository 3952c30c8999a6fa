"""How programs end that shut nothing down: quietly, completely and soon. Each on Zenoh and on DDS."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require


@pytest.fixture(params=['rmw_zenoh_cpp', DDS])
def start(request: pytest.FixtureRequest) -> Iterator[Start]:
    """A function that starts a program of this folder, on each wire."""
    require(request.param)
    with programs_in(isolated_env(request.param), Path(__file__).parent / 'programs') as start:
        yield start


@pytest.mark.slow
@pytest.mark.parametrize('executor', ['single', 'multi'])
def test_an_exit_beside_a_spinning_daemon_thread_is_quiet(start: Start, executor: str) -> None:
    for _ in range(5):
        assert start('spinning_daemon', executor).succeed() == 'end of main'


@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
@pytest.mark.parametrize('stage', ['CONTEXTS', 'SESSIONS', 'THREADS', 'SIGNALS'])
def test_ctrl_c_does_not_disturb_the_exit(start: Start, stage: str) -> None:
    assert start('ctrl_c_at_exit', stage).succeed() == 'the session is closed: True'


def test_all_blocked_workers_have_one_grace_together(start: Start) -> None:
    program = start('blocked_workers', 8)
    ended = float(program.expect('end of main at (.*)')[1])
    program.succeed()
    assert time.monotonic() - ended < 5  # and not 8 and more, one second for each
