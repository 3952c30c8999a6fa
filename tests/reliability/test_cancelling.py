"""Item 4: cancellations that come too early, too late, twice, for nobody, for all; answers on slow lines."""

from __future__ import annotations

import asyncio

import pytest
from action_msgs.srv import CancelGoal
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE

import goalwire
from goalwire.errors import GoalCanceled
from goalwire.rules.goals.states import GoalStatus
from goalwire.transport.faults import Delay, Kind

from .conftest import Evidence, MakeStage

Response = CancelGoal.Response


async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
    """Wait until cancelled, or for `order` ms."""
    await asyncio.sleep(goal.request.order / 1000)
    return Fibonacci.Result(sequence=[goal.request.order])


def test_what_is_cancelled_is_answered_by_the_codes_of_ros_2(stage: MakeStage, evidence: Evidence) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            arm.action_server(Fibonacci, 'count', count)
            client = mission.action(Fibonacci, 'count')
            raw = mission.client(CancelGoal, 'count/_action/cancel_goal')

            async def cancel(goal_id: bytes = bytes(16)) -> int:
                request = CancelGoal.Request()
                request.goal_info.goal_id.uuid = list(goal_id)
                return int((await raw.call(request, timeout=PATIENCE)).return_code)

            async with client.send(order=0, timeout=PATIENCE) as goal:
                await goal.result
                assert await cancel(goal.goal_id) == Response.ERROR_GOAL_TERMINATED
            assert await cancel(bytes(range(16))) == Response.ERROR_UNKNOWN_GOAL_ID
            async with (
                client.send(order=60_000, timeout=PATIENCE) as first,
                client.send(order=60_000) as second,
            ):
                assert await cancel() == Response.ERROR_NONE
                for each in (first, second):
                    with pytest.raises(GoalCanceled):
                        await each.result
                    outcomes.note('GoalCanceled')
                assert await cancel(first.goal_id) == Response.ERROR_GOAL_TERMINATED

    run(scenario())
    outcomes.note('answered by code', number=4)
    evidence(4, 'cancelled after the end, for nobody, all at once, twice', outcomes)


def test_a_cancellation_that_races_the_end_leaves_both_sides_of_one_mind(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.action_server(Fibonacci, 'count', count)
            client = mission.action(Fibonacci, 'count')
            await client.wait_for_server(timeout=PATIENCE)
            faults.add(Delay(0.002, jitter=0.004, kind=Kind.REQUEST))
            faults.add(Delay(0.002, jitter=0.004, kind=Kind.REPLY))
            for order in range(40):
                async with client.send(order=order % 10, timeout=PATIENCE) as goal:
                    agreed = await goal.cancel(timeout=PATIENCE)
                    with outcomes.counted():
                        await goal.result
                    assert goal.status in {GoalStatus.CANCELED, GoalStatus.SUCCEEDED}
                    assert agreed or goal.status is GoalStatus.SUCCEEDED

    run(scenario())
    assert outcomes.total == 40
    assert set(outcomes.counts) <= {'done', 'GoalCanceled'}
    outcomes.slowest = None
    evidence(4, '40 cancellations that race the end, requests and replies 2 to 6 ms late', outcomes)
