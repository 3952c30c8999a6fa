"""A peer that dies does not kill a program that left SIGPIPE as the system has it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')


@pytest.fixture(params=['rmw_zenoh_cpp', DDS])
def start(request: pytest.FixtureRequest) -> Iterator[Start]:
    """A function that starts a program of this folder, on each wire."""
    require(request.param)
    with programs_in(isolated_env(request.param), Path(__file__).parent / 'programs') as start:
        yield start


@pytest.mark.slow
def test_peers_that_die_do_not_kill_who_publishes(start: Start) -> None:
    floods = start('floods')
    floods.expect('ready')
    for _ in range(3):
        drinks = start('drinks')
        drinks.expect('has had enough')
        drinks.send_signal(signal.SIGSTOP)  # so that bytes wait for it when it dies
        send_more(floods)
        drinks.kill()
        drinks.wait()
        send_more(floods)
    survivor = start('drinks')
    survivor.expect('has had enough')
    floods.write_line('leave')
    assert floods.succeed().splitlines()[-1] == 'end'


def send_more(floods: Program) -> None:
    """Have it publish five hundred messages from now on."""
    for _ in range(2):
        floods.write_line('more')
        floods.expect('five hundred more')
