"""Item 1: a server gets Ctrl-C at the very beginning of a call, round after round: its client hears of it."""

from __future__ import annotations

import os
import signal
import sys

import pytest
from helpers.outcomes import Outcomes
from helpers.programs import Start

from .conftest import BETWEEN_PROCESSES, Evidence, told

ROUNDS = int(os.environ.get('GOALWIRE_TEST_INTERRUPTIONS', '8'))
"""GOALWIRE_TEST_INTERRUPTIONS=1000 makes it a thousand on each wire."""
WAYS = ('blocks', 'awaits', 'threads', 'bare')

pytestmark = [
    pytest.mark.slow,
    BETWEEN_PROCESSES,
    pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX'),
    pytest.mark.timeout(60 + 20 * ROUNDS),
]


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
