"""The ten steps where servers and mission have different Zenoh sessions, and meet in either way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from helpers.processes import Program
from helpers.robot import humanoid

pytestmark = pytest.mark.slow

AT_FIRST = ('joint_state_service', 'navigation_action_server', 'arm_action_server')
GOALWIRE = 'from goalwire.apps.cli.main import main; raise SystemExit(main())'
KINDS = {'native': 'eclipse', 'eclipse': 'native'}
RENDEZVOUS, ROUTER = 'the rendezvous', 'a router'


@pytest.fixture
def is_met_by(meeting: str, world: dict[str, str]) -> Iterator[dict[str, str]]:
    """The world, in which somebody's rendezvous is offered, or in which there is a router of its own."""
    if meeting == RENDEZVOUS:
        yield world
        return
    with Program(GOALWIRE, 'router', env=world) as router:
        router.expect('Ctrl-C ends it')
        yield world | {'GOALWIRE_ROUTER': 'off'}


@pytest.mark.parametrize(
    ('meeting', 'servers'),
    [
        (ROUTER, 'eclipse'),
        pytest.param(ROUTER, 'native', marks=pytest.mark.long),
        pytest.param(RENDEZVOUS, 'eclipse', marks=pytest.mark.long),
        pytest.param(RENDEZVOUS, 'native', marks=pytest.mark.long),
    ],
)
def test_the_ten_steps_end_well(is_met_by: dict[str, str], servers: str) -> None:
    serving = is_met_by | {'GOALWIRE_ZENOH': servers}
    with ExitStack() as running:
        for name in AT_FIRST:
            running.enter_context(humanoid(name, env=serving))
        asking = is_met_by | {'GOALWIRE_ZENOH': KINDS[servers], 'COLUMNS': '160'}
        mission = running.enter_context(humanoid('mission', '--battery-starts-late', env=asking))
        mission.expect('attempt 1')
        running.enter_context(humanoid('battery_service', env=serving))
        output = mission.succeed(timeout=80.0)
    assert '10 of 10 steps ended as they should' in output
