"""kill -9 of a server: an unmodified program under GOALWIRE_CALL_TIMEOUT is told at once, and by type."""

from __future__ import annotations

import time

import pytest
from helpers.held_up import HeldUp
from helpers.isolation import isolated_env, lease_variables
from helpers.programs import Start
from helpers.wires import DDS

pytestmark = pytest.mark.slow

LEASE_S = 1.0
WITHIN_S = {'rmw_zenoh_cpp': 1.0, DDS: LEASE_S + 1.0}
WAYS = {'call', 'call_async', 'await', 'get_result', 'get_result_async'}


@pytest.fixture
def world(network: str) -> dict[str, str]:
    """An environment on each wire in which DDS soon misses a participant; Zenoh learns of it at once."""
    return isolated_env(network) | {'CYCLONEDDS_URI': lease_variables(LEASE_S)['CYCLONEDDS_URI']}


@pytest.mark.parametrize('network', WITHIN_S, indirect=True)
def test_every_form_of_a_call_learns_of_the_death_of_its_server(start: Start, network: str) -> None:
    server = start('holds_on')
    server.expect('ready')
    program = start('waits', GOALWIRE_CALL_TIMEOUT='60')
    program.expect('waiting')
    for _ in range(4):  # three calls and a goal
        server.expect('began')
    held_up = HeldUp(program.pid)
    server.kill()
    killed = time.monotonic()
    told = [program.expect(r'^(\w+) (\w+Error|NoneType) (.*)').groups() for _ in WAYS]
    assert time.monotonic() - killed < WITHIN_S[network] + held_up.seconds
    assert {way for way, _, _ in told} == WAYS
    assert {(error, who) for _, error, who in told} == {('ServerLostError', 'node')}
    program.succeed()
