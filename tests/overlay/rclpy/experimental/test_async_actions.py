"""Actions of a node whose callbacks run in an asyncio loop: more than rclpy's AsyncNode has."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from helpers.loops import run
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.experimental import AsyncNode

MakeAsyncNode = Callable[..., AsyncNode]
Goal = ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]


def test_a_goal_runs_in_the_loop_with_feedback_and_result(make_async: MakeAsyncNode) -> None:
    async def execute(goal: Goal) -> Fibonacci.Result:
        for number in range(3):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[number]))
            await asyncio.sleep(0.001)
        goal.succeed()
        return Fibonacci.Result(sequence=[1, 2])

    async def scenario() -> None:
        heard: list[int] = []
        async with make_async('server') as server, make_async('caller') as caller:
            ActionServer(server, Fibonacci, 'count', execute)
            client = ActionClient(caller, Fibonacci, 'count')
            assert await asyncio.to_thread(client.wait_for_server, 10.0)
            goal = await client.send_goal_async(
                Fibonacci.Goal(order=3),
                feedback_callback=lambda message: heard.append(message.feedback.sequence[0]),
            )
            assert goal is not None
            assert goal.accepted
            response = await goal.get_result_async()
            assert response is not None
            assert response.status == GoalStatus.STATUS_SUCCEEDED
            assert list(response.result.sequence) == [1, 2]
            assert heard == [0, 1, 2]

    run(scenario())


def test_a_goal_is_cancelled(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        asked = asyncio.Event()

        def allow(_: object) -> CancelResponse:
            asked.set()
            return CancelResponse.ACCEPT

        async def execute(goal: Goal) -> Fibonacci.Result:
            await asked.wait()
            assert goal.is_cancel_requested
            goal.canceled()
            return Fibonacci.Result()

        async with make_async() as node:
            ActionServer(node, Fibonacci, 'count', execute, cancel_callback=allow)
            client = ActionClient(node, Fibonacci, 'count')
            assert await asyncio.to_thread(client.wait_for_server, 10.0)
            goal = await client.send_goal_async(Fibonacci.Goal())
            assert goal is not None
            await goal.cancel_goal_async()
            response = await goal.get_result_async()
            assert response is not None
            assert response.status == GoalStatus.STATUS_CANCELED

    run(scenario())


def test_leaving_the_block_ends_a_goal_that_executes(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        begun, ended = asyncio.Event(), asyncio.Event()

        async def execute(_: Goal) -> Fibonacci.Result:
            begun.set()
            try:
                await asyncio.Event().wait()
            finally:
                ended.set()
            return Fibonacci.Result()

        async with make_async('caller') as caller:
            client = ActionClient(caller, Fibonacci, 'count')
            async with make_async('server') as server:
                ActionServer(server, Fibonacci, 'count', execute)
                assert await asyncio.to_thread(client.wait_for_server, 10.0)
                await client.send_goal_async(Fibonacci.Goal())
                await begun.wait()
            assert ended.is_set()
            assert not client.server_is_ready()

    run(scenario())
