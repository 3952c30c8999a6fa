"""Scripted actions, seen by their clients."""

from __future__ import annotations

import asyncio

import pytest
from example_interfaces.action import Fibonacci

from goalwire import DeadlineError, GoalAborted, GoalCanceled, GoalRefused
from goalwire.testing import Graph, VirtualClock

STEPS = [Fibonacci.Feedback(sequence=[number]) for number in range(3)]
RESULT = Fibonacci.Result(sequence=[0, 1, 1])


def test_feedback_comes_in_its_rhythm_and_the_result_after_it(graph: Graph, clock: VirtualClock) -> None:
    action = graph.action(Fibonacci, 'count', feedback=STEPS, every=0.5, result=RESULT)
    outcome = graph.send_goal(Fibonacci, 'count', order=3)
    assert (outcome.feedback, outcome.result) == (STEPS, RESULT)
    assert clock.elapsed == 1.5
    assert action.goals == [Fibonacci.Goal(order=3)]
    assert action.endings == ['succeeded']


def test_a_goal_without_a_script_succeeds_at_once(graph: Graph, clock: VirtualClock) -> None:
    graph.action(Fibonacci, 'count')
    assert graph.send_goal(Fibonacci, 'count').result == Fibonacci.Result()
    assert clock.elapsed == 0.0


def test_the_result_may_be_made_of_the_goal(graph: Graph) -> None:
    graph.action(Fibonacci, 'count', result=lambda goal: Fibonacci.Result(sequence=[goal.order]))
    assert graph.send_goal(Fibonacci, 'count', order=7).result == Fibonacci.Result(sequence=[7])


def test_goals_are_refused_all_or_some(graph: Graph) -> None:
    action = graph.action(Fibonacci, 'count', refuse=lambda goal: goal.order < 0)
    with pytest.raises(GoalRefused):
        graph.send_goal(Fibonacci, 'count', order=-1)
    graph.send_goal(Fibonacci, 'count', order=1)
    action.conduct.refuse = True
    with pytest.raises(GoalRefused):
        graph.send_goal(Fibonacci, 'count', order=2)
    assert [goal.order for goal in action.goals] == [1]
    assert [goal.order for goal in action.refused] == [-1, 2]


def test_an_aborted_goal_sends_its_result_along(graph: Graph) -> None:
    action = graph.action(Fibonacci, 'count', abort=True, result=RESULT)
    with pytest.raises(GoalAborted) as caught:
        graph.send_goal(Fibonacci, 'count')
    assert caught.value.result == RESULT
    assert action.endings == ['aborted']


def test_a_goal_that_never_ends_runs_until_it_is_cancelled(graph: Graph, clock: VirtualClock) -> None:
    action = graph.action(Fibonacci, 'count', feedback=STEPS, never_ends=True)
    with pytest.raises(DeadlineError):
        graph.send_goal(Fibonacci, 'count', order=5, timeout=20.0)
    assert clock.elapsed == 20.0
    assert action.cancels == [Fibonacci.Goal(order=5)]
    assert action.endings == ['canceled']


def test_a_cancel_ends_the_goal_between_two_feedbacks(graph: Graph, clock: VirtualClock) -> None:
    action = graph.action(Fibonacci, 'count', feedback=STEPS, every=10.0, result=RESULT)

    async def play() -> None:
        async with (
            graph.node('client') as node,
            node.action(Fibonacci, 'count').send(order=5) as run,
        ):
            await asyncio.sleep(13.0)
            assert await run.cancel()
            with pytest.raises(GoalCanceled):
                await run.result

    asyncio.run(play())
    assert clock.elapsed == 13.0
    assert action.endings == ['canceled']


def test_a_cancel_may_be_turned_down(graph: Graph, clock: VirtualClock) -> None:
    action = graph.action(Fibonacci, 'count', feedback=STEPS, every=1.0, cancel=False)

    async def play() -> None:
        async with (
            graph.node('client') as node,
            node.action(Fibonacci, 'count').send(order=5) as run,
        ):
            assert not await run.cancel()
            await run.result

    asyncio.run(play())
    assert clock.elapsed == 3.0
    assert (len(action.cancels), list(action.endings)) == (1, ['succeeded'])


def test_an_action_that_closes_aborts_what_runs(graph: Graph) -> None:
    action = graph.action(Fibonacci, 'count', never_ends=True)

    async def play() -> None:
        async with (
            graph.node('client') as node,
            node.action(Fibonacci, 'count').send(order=5) as run,
        ):
            await asyncio.to_thread(action.close)
            await run.result

    with pytest.raises(GoalAborted):
        asyncio.run(play())


def test_what_was_asked_for_can_be_asserted(graph: Graph) -> None:
    action = graph.action(Fibonacci, 'count')
    with pytest.raises(AssertionError, match="action '/count' got no goal"):
        action.assert_goal(order=1)
    action.assert_goals(0)
    graph.send_goal(Fibonacci, 'count', order=1)
    action.assert_goal(order=1)
    with pytest.raises(AssertionError, match="action '/count', last goal: order is 1, not 2"):
        action.assert_goal(order=2)
    with pytest.raises(AssertionError, match=r"action '/count': wanted 2 goals, got 1:\n  .*order=1"):
        action.assert_goals(2)
    assert action.wait_for() == [Fibonacci.Goal(order=1)]
