"""kill -9 of a server: an unmodified program under GOALWIRE_CALL_TIMEOUT is told at once, and by type."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from helpers.isolation import isolated_env
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

pytestmark = pytest.mark.slow

LEASE_S = 1.0
SHORT_LEASE = (
    '<CycloneDDS><Domain><Discovery><LeaseDuration>1s</LeaseDuration></Discovery></Domain></CycloneDDS>'
)
WITHIN_S = {'rmw_zenoh_cpp': 1.0, DDS: LEASE_S + 1.0}
WAYS = {'call', 'call_async', 'await', 'get_result', 'get_result_async'}


@pytest.fixture(params=WITHIN_S)
def rmw(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    require(name)
    return name


@pytest.fixture
def start(rmw: str) -> Iterator[Start]:
    """A function that starts a program in a world of its own."""
    with programs_in(isolated_env(rmw) | {'CYCLONEDDS_URI': SHORT_LEASE}) as start:
        yield start


def test_every_form_of_a_call_learns_of_the_death_of_its_server(start: Start, rmw: str) -> None:
    server = start('holds_on')
    server.expect('ready')
    program = start('waits', GOALWIRE_CALL_TIMEOUT='60')
    program.expect('waiting')
    for _ in range(4):  # three calls and a goal
        server.expect('began')
    server.kill()
    killed = time.monotonic()
    told = [program.expect(r'^(\w+) (\w+Error|NoneType) (.*)').groups() for _ in WAYS]
    assert time.monotonic() - killed < WITHIN_S[rmw]
    assert {way for way, _, _ in told} == WAYS
    assert {(error, who) for _, error, who in told} == {('ServerLostError', 'node')}
    program.succeed()
