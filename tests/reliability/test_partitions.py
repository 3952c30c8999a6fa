"""Item 9 within one process: what calls say before and after the end of the lease, and once it heals."""

from __future__ import annotations

import asyncio

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from std_srvs.srv import Trigger

import goalwire
from goalwire.testing import VirtualClock

from .conftest import Evidence, MakeStage


async def partition(stage: MakeStage, here: str, there: str, one_way: bool, outcomes: Outcomes) -> list[str]:
    """Call before, during and after a partition; return how the calls ended."""
    ends: list[str] = []
    async with stage() as (arm, mission, faults):
        arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
        client = mission.client(Trigger, 'ask')

        async def call(seconds: float) -> None:
            before = outcomes.counts.copy()
            with outcomes.counted():
                await client.call(timeout=seconds)
            ends.extend(outcomes.counts - before)

        await call(5.0)
        faults.partition(here, there, one_way=one_way, lease=0.3)
        for seconds in (0.05, 0.6, 0.05):
            await call(seconds)
        faults.heal()
        await call(5.0)
    return ends


@pytest.mark.parametrize('one_way', [False, True])
def test_a_partition_is_a_slow_server_then_a_lost_one_then_none_and_then_is_over(
    stage: MakeStage, evidence: Evidence, one_way: bool
) -> None:
    outcomes = Outcomes()
    ends = run(partition(stage, 'arm', 'mission', one_way, outcomes))
    assert ends == ['done', 'DeadlineError', 'ServerLostError', 'NoServerError', 'done']
    evidence(9, f'the wire parts them{", the client is deaf" if one_way else ""}; lease of 0.3 s', outcomes)


def test_a_server_that_does_not_hear_a_client_that_hears_it_is_a_slow_one(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    ends = run(partition(stage, 'mission', 'arm', True, outcomes))
    assert ends == ['done', *['DeadlineError'] * 3, 'done']
    evidence(9, 'the wire parts them, the client is mute', outcomes)


@pytest.mark.parametrize('transport_name', ['goalwire_memory'], indirect=True)
@pytest.mark.parametrize(('seconds', 'end'), [(1, 'done'), (5, 'done'), (30, 'ServerLostError')])
def test_a_goal_outlives_a_partition_that_is_shorter_than_the_lease(
    stage: MakeStage, evidence: Evidence, seconds: int, end: str
) -> None:
    outcomes = Outcomes()

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        for number in range(goal.request.order):
            goal.feedback(sequence=[number])
            await asyncio.sleep(1.0)
        return Fibonacci.Result()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.action_server(Fibonacci, 'count', count)

            async def part() -> None:
                await asyncio.sleep(2.5)
                faults.partition('arm', 'mission', lease=10.0)
                await asyncio.sleep(seconds)
                faults.heal()

            parting = asyncio.create_task(part())
            with outcomes.counted():
                await mission.action(Fibonacci, 'count').call(order=40, timeout=100.0)
            await parting

    with VirtualClock():
        asyncio.run(scenario())
    assert outcomes.counts == {end: 1}
    outcomes.slowest = None
    evidence(9, f'partition of {seconds} s under a goal, lease of 10 s (virtual time)', outcomes)
