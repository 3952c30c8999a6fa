"""Items 5 and 11: answers, feedback and results that overtake each other; and a reader that is too slow."""

from __future__ import annotations

import asyncio
import time

from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE

import goalwire
from goalwire.entities.actions.client_goal_handle import FEEDBACK_LIMIT
from goalwire.errors import GoalCanceled
from goalwire.transport.faults import Delay, Kind

from .conftest import Evidence, MakeStage


def test_feedback_that_overtakes_the_acceptance_is_delivered(stage: MakeStage, evidence: Evidence) -> None:
    outcomes = Outcomes()

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        for number in range(5):
            goal.feedback(sequence=[number])
        return Fibonacci.Result(sequence=[5])

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.action_server(Fibonacci, 'count', count)
            late = faults.add(Delay(0.2, kind=Kind.REPLY, name='/count/_action/send_goal'))
            async with mission.action(Fibonacci, 'count').send(timeout=PATIENCE) as goal:
                heard = [list(feedback.sequence) async for feedback in goal.feedback]
                assert list((await goal.result).sequence) == [5]
            assert late.struck == 1
            assert heard == [[0], [1], [2], [3], [4]]
            outcomes.note('done')
            outcomes.note('feedback messages', number=len(heard))

    run(scenario())
    evidence(5, 'the answer to a goal 0.2 s late, behind its feedback and its end', outcomes)


def test_a_reader_that_is_too_slow_costs_it_the_oldest_and_nobody_else_anything(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def pour(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        for number in range(goal.request.order):
            goal.feedback(sequence=[number])
            if number % 100 == 0:
                await asyncio.sleep(0.001)
        poured.set()
        await asyncio.Event().wait()
        raise AssertionError

    poured = asyncio.Event()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            arm.action_server(Fibonacci, 'pour', pour)
            async with mission.action(Fibonacci, 'pour').send(order=5000, timeout=20.0) as goal:
                first = await anext(goal.feedback)
                assert first.sequence[0] >= 0
                await poured.wait()
                asked = time.monotonic()
                assert await goal.cancel(timeout=PATIENCE)
                try:
                    await goal.result
                except GoalCanceled:
                    outcomes.note('GoalCanceled', time.monotonic() - asked)
                heard = [feedback.sequence[0] async for feedback in goal.feedback]
            assert len(heard) <= FEEDBACK_LIMIT
            assert heard == sorted(heard)
            # The result may overtake the last of them; the newest that came are kept.
            assert heard
            assert heard[0] > 0
            outcomes.note('feedback messages kept', number=len(heard))

    run(scenario())
    outcomes.expect_within(1.0)
    evidence(11, '5000 feedback messages at once for a reader that takes one, then a cancellation', outcomes)
