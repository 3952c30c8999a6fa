"""Item 1: a server that dies at any point of a call or a goal; its client is told, soon and by type."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from helpers.pending import left_pending
from std_srvs.srv import Trigger

import goalwire
from goalwire.errors import ClosedError
from goalwire.transport.faults import Kill, Point

from .conftest import Evidence, MakeStage

GOALS = {
    'before accept': (Point.GOAL_RECEIVED, 1),
    'after accept': (Point.GOAL_ACCEPTED, 1),
    'mid-feedback': (Point.FEEDBACK_SENT, 2),
    'after result, before reply': (Point.RESULT_READY, 1),
}
CALLS = {'before the handler': Point.REQUEST_RECEIVED, 'after the handler, before reply': Point.HANDLER_DONE}


async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
    """Give feedback now and then."""
    for number in range(goal.request.order):
        goal.feedback(sequence=[number])
        await asyncio.sleep(0.01)
    return Fibonacci.Result(sequence=[goal.request.order])


@pytest.mark.parametrize('when', GOALS)
def test_a_server_that_vanishes_fails_its_goal_by_type_within_a_second(
    stage: MakeStage, evidence: Evidence, when: str
) -> None:
    point, nth = GOALS[when]
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.action_server(Fibonacci, 'count', count)
            fault = faults.add(Kill('arm', point, '/count', nth=nth))
            with outcomes.counted(lambda: fault.struck_at):
                await mission.action(Fibonacci, 'count').call(order=3, timeout=PATIENCE)

    run(scenario())
    assert outcomes.counts == {'ServerLostError': 1}
    outcomes.expect_within(1.0)
    evidence(1, f'the server vanishes {when}', outcomes)


@pytest.mark.parametrize('when', CALLS)
def test_a_server_that_vanishes_fails_its_call_by_type_within_a_second(
    stage: MakeStage, evidence: Evidence, when: str
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            client = mission.client(Trigger, 'ask')
            with outcomes.counted():
                await client.call(timeout=PATIENCE)
            fault = faults.add(Kill('arm', CALLS[when], '/ask'))
            with outcomes.counted(lambda: fault.struck_at):
                await client.call(timeout=PATIENCE)

    run(scenario())
    assert outcomes.counts == {'done': 1, 'ServerLostError': 1}
    outcomes.expect_within(1.0)
    evidence(1, f'the server vanishes {when}', outcomes)


def test_a_goal_that_does_not_end_when_its_client_leaves_it_leaves_nothing_there(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def hang(_: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        while not over.is_set():
            with suppress(asyncio.CancelledError):
                await over.wait()
        return Fibonacci.Result()

    over = asyncio.Event()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            arm.action_server(Fibonacci, 'hang', hang)
            client = mission.action(Fibonacci, 'hang')
            await client.wait_for_server(timeout=PATIENCE)
            for _ in range(3):
                with outcomes.counted():
                    async with client.send(timeout=0.05, grace=0.05) as goal:
                        await goal.result
            assert left_pending(mission._open_core()) == {}
            with pytest.raises(ClosedError):
                await goal.result
            over.set()

    run(scenario())
    assert outcomes.counts == {'DeadlineError': 3}
    evidence(1, 'the server neither ends its goals nor lets them be cancelled', outcomes)
