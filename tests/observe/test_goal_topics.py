"""Goals of another program's action server, heard on its topics and asked for by its services."""

from __future__ import annotations

import asyncio
from typing import Any

from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE

import goalwire
from goalwire.observe.goal_topics import (
    cancel_request,
    fetch_known_goals,
    follow_goals,
    goal_request,
    goals_canceling,
    result_request,
)
from goalwire.observe.goals import Goal, GoalTable


async def _count(goal: Any) -> Fibonacci.Result:
    goal.feedback(sequence=[0, 1])
    await asyncio.Event().wait()
    return Fibonacci.Result()


def test_a_goal_is_followed_from_its_sending_to_its_end(isolated: dict[str, str]) -> None:
    async def play() -> None:
        goals, statuses = GoalTable(), list[str]()
        fed, ended = asyncio.Event(), asyncio.Event()

        def on_status(goal: Goal) -> None:
            statuses.append(goal.status)
            if not goal.is_active:
                ended.set()

        async with goalwire.Node('robot') as robot, goalwire.Node('watching') as node:
            robot.action_server(Fibonacci, 'count', _count)
            following = asyncio.create_task(
                follow_goals(node, '/count', Fibonacci, goals, on_status, lambda _goal: fed.set())
            )
            parts = Fibonacci.Impl
            sender: Any = node.client(parts.SendGoalService, '/count/_action/send_goal')
            answer = await sender.call(goal_request(Fibonacci, bytes(range(16)), Fibonacci.Goal(order=3)))
            assert answer.accepted
            await fed.wait()
            [known] = await fetch_known_goals(node, '/count', PATIENCE)
            assert known.goal_id == bytes(range(16)).hex()
            from action_msgs.srv import CancelGoal

            canceler = node.client(CancelGoal, '/count/_action/cancel_goal')
            assert goals_canceling(await canceler.call(cancel_request(known.goal_id))) == [known.goal_id]
            results: Any = node.client(parts.GetResultService, '/count/_action/get_result')
            assert (await results.call(result_request(Fibonacci, known.goal_id))).status == 5
            await ended.wait()
            following.cancel()
            await asyncio.gather(following, return_exceptions=True)
            [goal] = goals
            assert (goal.status, list(goal.feedback.sequence)) == ('CANCELED', [0, 1])
            assert statuses[-1] == 'CANCELED'

    asyncio.run(asyncio.wait_for(play(), 3 * PATIENCE))


def test_a_server_without_goals_knows_none(isolated: dict[str, str]) -> None:
    async def play() -> None:
        async with goalwire.Node('robot') as robot, goalwire.Node('asking') as node:
            robot.action_server(Fibonacci, 'count', _count)
            assert await fetch_known_goals(node, '/count', 0.05) == []

    asyncio.run(asyncio.wait_for(play(), PATIENCE))


def test_a_request_to_cancel_names_a_goal_a_time_or_neither() -> None:
    request = cancel_request(before=12.5)
    assert (request.goal_info.stamp.sec, request.goal_info.stamp.nanosec) == (12, 500_000_000)
    assert not any(request.goal_info.goal_id.uuid)
    assert not any(cancel_request().goal_info.goal_id.uuid)
