"""Item 1: a server gets Ctrl-C at the very beginning of a call, round after round: its client hears of it."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator

import pytest
from helpers.outcomes import Outcomes
from helpers.programs import Start, programs_in
from helpers.wires import require

from .conftest import BETWEEN_PROCESSES, PROGRAMS, Evidence, impatient_world, told

ROUNDS = int(os.environ.get('GOALWIRE_TEST_INTERRUPTIONS', '8'))
"""GOALWIRE_TEST_INTERRUPTIONS=1000 makes it a thousand on each wire."""
WAYS = ('blocks', 'awaits', 'threads', 'bare')

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX'),
    pytest.mark.timeout(60 + 20 * ROUNDS),
]


@pytest.fixture(params=BETWEEN_PROCESSES)
def transport_name(request: pytest.FixtureRequest) -> str:
    """The wires between processes."""
    name: str = request.param
    require(name)
    return name


@pytest.fixture
def start(transport_name: str) -> Iterator[Start]:
    """A function that starts a program of this folder, in a world where peers are missed soon."""
    with programs_in(impatient_world(transport_name), PROGRAMS) as start:
        yield start


def test_a_call_whose_server_gets_ctrl_c_fails_by_type_and_never_at_its_deadline(
    start: Start, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    mission = start('mission')
    mission.expect('ready')
    for number in range(ROUNDS):
        way = WAYS[number % len(WAYS)]
        service = f'sleep_{number // 2 % 10}'  # a new one, or one whose server has just gone
        with start('sleeper', service, way) as sleeper:
            sleeper.expect('ready')
            mission.write_line(f'call {service} 20.0')
            sleeper.expect('asked')
            sleeper.send_signal(signal.SIGINT)
            kind = told(mission, outcomes)
            assert kind in {'ServerFailedError', 'ServerLostError'}, f'round {number}, which {way}'
            sleeper.expect('gone')  # it has left: killed before, it would stay in sight until its lease ends
    mission.write_line('leave')
    mission.succeed()
    evidence(1, 'Ctrl-C for the server in the middle of a call', outcomes)
