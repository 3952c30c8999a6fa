"""Item 9 within one process: what calls say before and after the end of the lease, and once it heals."""

from __future__ import annotations

import asyncio
import time

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from std_srvs.srv import Trigger

import goalwire
from goalwire.testing import VirtualClock

from .conftest import Evidence, MakeStage


async def acquainted(*nodes: goalwire.Node) -> None:
    """Wait until each node knows whose endpoints those of `/ask` are: a partition parts nodes by name."""
    for node in nodes:
        changes = node.graph.changes()
        async with asyncio.timeout(PATIENCE):
            while len({end.node.name for end in node.graph.endpoints() if end.name == '/ask'}) < len(nodes):
                await anext(changes)
        changes.close()


@pytest.mark.parametrize('one_way', [False, True])
def test_a_partition_is_a_slow_server_then_a_lost_one_then_none_and_then_is_over(
    stage: MakeStage, evidence: Evidence, one_way: bool
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            client = mission.client(Trigger, 'ask')
            await client.call(timeout=PATIENCE)
            await acquainted(arm, mission)
            faults.partition('arm', 'mission', one_way=one_way, lease=1000.0)
            with outcomes.counted():
                await client.call(timeout=0.05)
            waiting = asyncio.create_task(client.call(timeout=PATIENCE))
            await asyncio.sleep(0)
            assert client._core.pending, 'a call to a server in sight is sent at once'
            noticed = time.monotonic_ns()
            faults.partition('arm', 'mission', one_way=one_way, lease=0.0)
            with outcomes.counted(lambda: noticed):
                await waiting
            with outcomes.counted():
                await client.call(timeout=0.05)
            faults.heal()
            with outcomes.counted():
                await client.call(timeout=PATIENCE)

    run(scenario())
    assert list(outcomes.counts) == ['DeadlineError', 'ServerLostError', 'NoServerError', 'done']
    evidence(9, f'the wire parts them{", the client is deaf" if one_way else ""}', outcomes)


def test_a_server_that_does_not_hear_a_client_that_hears_it_is_a_slow_one(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            client = mission.client(Trigger, 'ask')
            await client.call(timeout=PATIENCE)
            await acquainted(arm, mission)
            faults.partition('mission', 'arm', one_way=True, lease=0.0)
            for _ in range(3):
                with outcomes.counted():
                    await client.call(timeout=0.05)
            faults.heal()
            with outcomes.counted():
                await client.call(timeout=PATIENCE)

    run(scenario())
    assert outcomes.counts == {'DeadlineError': 3, 'done': 1}
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
