"""Item 2: a client that is killed before it hears that its goal was accepted; its server goes on."""

from __future__ import annotations

import pytest
from helpers.outcomes import Outcomes
from helpers.programs import Start

from .conftest import BETWEEN_PROCESSES, Evidence, told

pytestmark = [pytest.mark.slow, BETWEEN_PROCESSES]


def test_the_goal_of_a_client_that_never_heard_the_answer_ends_as_the_server_chose(
    start: Start, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    arm = start('arm', GOALWIRE_FAULTS='delay 0.5 kind=reply name=/count/_action/send_goal times=1')
    first, second = start('mission'), start('mission')
    for program in (arm, first, second):
        program.expect('ready')
    first.write_line('goal 1000 60.0')
    arm.expect('goal begun')
    first.kill()
    arm.expect('goal left')
    outcomes.note('cancelled at the server')
    second.write_line('goal 3 10.0')
    assert told(second, outcomes) == 'done'
    second.write_line('leave')
    second.succeed()
    evidence(2, 'SIGKILL of the client before it hears of the acceptance; on_client_lost cancels', outcomes)
