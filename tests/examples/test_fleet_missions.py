"""Missions of a fleet, handed out by an engine on Postgres: each ends once, whoever is killed."""

from __future__ import annotations

from contextlib import ExitStack
from importlib.util import find_spec

import pytest
from helpers.postgres import find_programs

from benchmarks.fleet_missions import Plan, carry_out

PLAN = Plan(60, 6, 3, kill_every=2.0, restarts=3, worker_kills=9, robot_kills=1)
IN_TIME = 600.0


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.skipif(find_spec('dbos') is None, reason='needs: pip install dbos')
@pytest.mark.skipif(find_programs() is None, reason='needs: apt-get install postgresql')
def test_each_mission_ends_once_whoever_is_killed() -> None:
    with ExitStack() as stack:
        site, found, states, _ = carry_out(PLAN, stack, IN_TIME)
        assert states == {'SUCCESS': PLAN.missions}
        assert found.ended == dict.fromkeys(range(PLAN.missions), 1)
        assert all(len(robots) == 1 for robots in found.on.values())
        assert found.overlaps == 0
        lifts = range(PLAN.missions // 4)
        assert {robot for each in lifts for robot in found.on[each]} <= {'r0', 'r2', 'r4'}
        assert site.kills['worker']
        assert site.kills['Postgres']
