"""Items 9 and 10 without rights: a Zenoh link through a TCP relay that delays it, stalls it, cuts it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import NamedTuple

import pytest
from helpers.isolation import free_port
from helpers.outcomes import Outcomes
from helpers.processes import Program
from helpers.relay import Relay, Way, relay

from .conftest import LONG, PROGRAMS, Evidence, impatient_world, told

pytestmark = [
    pytest.mark.slow,
    pytest.mark.parametrize('transport_name', ['rmw_zenoh_cpp'], indirect=True),
]


class Line(NamedTuple):
    """A client and the relay between it and its server."""

    mission: Program
    relay: Relay

    def call(self, seconds: float, outcomes: Outcomes) -> str:
        self.mission.write_line(f'call ask {seconds}')
        return told(self.mission, outcomes)


@pytest.fixture
def line(transport_name: str) -> Iterator[Line]:
    """The client is of Zenoh's mode `client`, so that everything passes the relay."""
    world = impatient_world(transport_name)
    port, server_port = free_port(), free_port()
    lease = world.pop('ZENOH_CONFIG_OVERRIDE')
    there = f'connect/endpoints=[];listen/endpoints=["tcp/127.0.0.1:{server_port}"]'
    here = f'mode="client";connect/endpoints=["tcp/127.0.0.1:{port}"]'
    with ExitStack() as stack:
        programs = []
        running = stack.enter_context(relay(port, server_port))
        for name, place in (('arm', there), ('mission', here)):
            env = world | {'GOALWIRE_ROUTER': 'off', 'ZENOH_CONFIG_OVERRIDE': f'{place};{lease}'}
            programs.append(stack.enter_context(Program(PROGRAMS / f'{name}.py', env=env)))
            programs[-1].expect('ready')
        whole = Line(programs[1], running)
        assert whole.call(20.0, Outcomes()) == 'done'
        yield whole


def test_a_late_line_makes_calls_late_and_loses_none(line: Line, evidence: Evidence) -> None:
    outcomes = Outcomes()
    line.relay.delay_s = 0.1
    for _ in range(5):
        assert line.call(5.0, outcomes) == 'done'
    evidence(10, 'TCP relay, 100 ms late', outcomes)


@pytest.mark.parametrize(
    'ways',
    [
        (),
        pytest.param((Way.TO_SERVER,), marks=LONG),
        pytest.param((Way.TO_CLIENT,), marks=LONG),
    ],
    ids=['stalled', 'mute', 'deaf'],
)
def test_a_stalled_line_ends_calls_by_type_and_works_again_once_it_flows(
    line: Line, evidence: Evidence, ways: tuple[Way, ...]
) -> None:
    outcomes = Outcomes()
    line.relay.stall(*ways)
    assert line.call(0.2, outcomes) == 'DeadlineError'
    line.call(1.5, outcomes)
    line.relay.release()
    # The line was still for longer than the lease. The side that missed the other has said so, the line
    # held that up too, and what it meets now is the next call.
    if line.call(20.0, outcomes) == 'ServerLostError':
        assert line.call(20.0, outcomes) == 'done'
    assert outcomes.counts['done'] == 1
    names = ' and '.join(way.value for way in ways) or 'both ways'
    evidence(9, f'TCP relay stalled for 1.7 s, {names}', outcomes)


def test_a_cut_line_is_noticed_at_once_and_found_again(line: Line, evidence: Evidence) -> None:
    outcomes = Outcomes()
    line.mission.write_line('call hang 10.0')
    with pytest.raises(AssertionError, match='without a line'):
        line.mission.expect('^ended', timeout=0.3)
    line.relay.cut()
    assert told(line.mission, outcomes) == 'ServerLostError'
    assert line.call(0.2, outcomes) == 'NoServerError'
    line.relay.mend()
    assert line.call(20.0, outcomes) == 'done'
    evidence(9, 'TCP connections cut, none accepted for a while', outcomes)
