"""kill -9 of an action client: its server learns of it and, if it is told to, ends the client's goals."""

from __future__ import annotations

import time

import pytest
from helpers.isolation import isolated_env, lease_variables
from helpers.processes import Program
from helpers.programs import Start
from helpers.wires import DDS

pytestmark = pytest.mark.slow

LEASE_S = 1.0
ZENOH = 'rmw_zenoh_cpp'
WITHIN_S = {ZENOH: 1.0, DDS: LEASE_S + 1.0}


@pytest.fixture
def world(network: str) -> dict[str, str]:
    """An environment on each wire in which DDS soon misses a participant; Zenoh learns of it at once."""
    return isolated_env(network) | {'CYCLONEDDS_URI': lease_variables(LEASE_S)['CYCLONEDDS_URI']}


def serve(start: Start, choice: str) -> Program:
    server = start('goal_watcher', choice)
    server.expect('ready')
    return server


def kill(program: Program) -> float:
    """kill -9; return when."""
    at = time.monotonic()
    program.kill()
    program.wait()
    return at


@pytest.mark.parametrize(
    ('network', 'choice'), [(ZENOH, 'cancel'), (ZENOH, 'abort'), (DDS, 'cancel')], indirect=['network']
)
def test_the_goals_of_a_client_that_was_killed_end_soon(start: Start, network: str, choice: str) -> None:
    server = serve(start, choice)
    victim = start('goal_sender', 7)
    server.expect('began 7')
    other = start('goal_sender', 8)
    server.expect('began 8')
    killed_at = kill(victim)
    ended_at = float(server.expect(r'ended 7 at ([\d.]+)').group(1))
    assert ended_at - killed_at < WITHIN_S[network]
    assert 'ended 8' not in server.output
    other.kill()
    server.expect('ended 8')


@pytest.mark.parametrize(('network', 'choice'), [(ZENOH, 'cancel'), (DDS, 'abort')], indirect=['network'])
def test_a_client_that_is_killed_before_its_goal_is_accepted_leaves_no_goal_behind(
    start: Start, choice: str
) -> None:
    server = serve(start, choice)
    undecided = start('goal_sender', 1)
    server.expect('deciding')
    running = start('goal_sender', 7)
    server.expect('began 7')
    undecided.kill()
    running.kill()
    server.expect('ended 7')  # the loss of one is known; that of the other may be told a moment later
    server.write_line('accept')
    server.expect('decided')
    start('goal_sender', 9)
    server.expect('began 9')  # it works on
    if 'began 1 ' in server.output and 'ended 1 ' not in server.output:
        server.expect('ended 1 ')
