"""Item 12, in small: many goals and many clients at once. The large numbers are those of the soak."""

from __future__ import annotations

import asyncio

from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from std_srvs.srv import Trigger

import goalwire

from .conftest import Evidence, MakeStage

GOALS, CLIENTS, CALLS = 300, 30, 20


def test_hundreds_of_goals_and_calls_at_once_each_get_their_own_answer(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    begun = 0

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        nonlocal begun
        begun += 1
        if begun == GOALS:
            together.set()
        await together.wait()
        return Fibonacci.Result(sequence=[goal.request.order])

    together = asyncio.Event()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            arm.action_server(Fibonacci, 'count', count)
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            action = mission.action(Fibonacci, 'count')

            async def goal(order: int) -> None:
                with outcomes.counted():
                    assert list((await action.call(order=order, timeout=30.0)).sequence) == [order]

            async def calls() -> None:
                with mission.client(Trigger, 'ask') as client:
                    for _ in range(CALLS):
                        with outcomes.counted():
                            await client.call(timeout=30.0)

            async with asyncio.TaskGroup() as group:
                for order in range(GOALS):
                    group.create_task(goal(order))
                for _ in range(CLIENTS):
                    group.create_task(calls())

    run(scenario())
    assert outcomes.counts == {'done': GOALS + CLIENTS * CALLS}
    evidence(12, f'{GOALS} goals at once, {CLIENTS} clients with {CALLS} calls each', outcomes)
