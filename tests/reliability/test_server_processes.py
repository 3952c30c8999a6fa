"""Items 1 and 9: processes that are killed, or stopped for a while, with their clients watching."""

from __future__ import annotations

import signal
import time

import pytest
from helpers.held_up import HeldUp
from helpers.outcomes import Outcomes
from helpers.processes import Program
from helpers.programs import Start
from helpers.wires import DDS

from .conftest import BETWEEN_PROCESSES, LEASE_S, Evidence, told

pytestmark = [pytest.mark.slow, BETWEEN_PROCESSES]


def started(start: Start, name: str, faults: str = '') -> Program:
    program = start(name, GOALWIRE_FAULTS=faults)
    program.expect('ready')
    return program


KILLS = {
    'before accept': 'goal_received /count',
    'after accept': 'goal_accepted /count',
    'mid-feedback': 'feedback_sent /count nth=3',
    'after result, before reply': 'result_ready /count',
}


@pytest.mark.parametrize('when', KILLS)
def test_a_killed_process_fails_its_goal_by_type_within_its_lease(
    start: Start, transport_name: str, evidence: Evidence, when: str
) -> None:
    outcomes = Outcomes()
    arm = started(start, 'arm', f'kill arm {KILLS[when]} process=yes')
    mission = started(start, 'mission')
    held_up = HeldUp(mission.pid)
    mission.write_line('goal 5 10.0')
    assert arm.wait() == -signal.SIGKILL
    died = time.monotonic()
    assert told(mission, outcomes, died) == 'ServerLostError'
    outcomes.expect_within(1.0 if transport_name != DDS else LEASE_S + 1.0, held_up)
    mission.write_line('leave')
    mission.succeed()
    evidence(1, f'SIGKILL of the server {when}', outcomes)


def test_a_stopped_process_is_a_slow_one_until_its_lease_ends_and_answers_again_when_it_goes_on(
    start: Start, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    arm, mission = started(start, 'arm'), started(start, 'mission')
    mission.write_line('call ask 5.0')
    assert told(mission, outcomes) == 'done'
    arm.send_signal(signal.SIGSTOP)
    stopped = time.monotonic()
    mission.write_line('call ask 0.3')
    assert told(mission, outcomes, stopped) == 'DeadlineError'
    mission.write_line('call ask 10.0')
    assert told(mission, outcomes, stopped) == 'ServerLostError'
    mission.write_line('call ask 0.2')
    # The graph may learn of it a moment later than the calls.
    assert told(mission, outcomes, stopped) in {'NoServerError', 'ServerLostError'}
    arm.send_signal(signal.SIGCONT)
    mission.write_line('call ask 10.0')
    assert told(mission, outcomes) == 'done'
    mission.write_line('leave')
    mission.succeed()
    evidence(9, 'SIGSTOP of the server, for longer than its lease, then SIGCONT', outcomes)
