"""Listens to the goals of one action: its status and feedback topics, and the events of its services."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.observe.clock import wall_offset
from goalwire.observe.goals import Goal, GoalTable, ReportedGoal, read_reported_goals

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable

    from action_msgs.srv import CancelGoal

_FEEDBACK_DEPTH = 1000


def _ignore(_goal: Any) -> None:
    pass


async def follow_goals(
    node: goalwire.Node,
    action: str,
    cls: Any,
    goals: GoalTable,
    on_status: Callable[[Goal], object] = _ignore,
    on_feedback: Callable[[Goal], object] = _ignore,
) -> None:
    """Keep the goals of an action of class `cls` in the table `goals`, until this coroutine is cancelled.

    `on_status` is called with each goal whose status has changed, `on_feedback` with each goal that has new
    feedback.
    """
    goals.watch(action, monotonic())
    statuses = _statuses(node, action)
    try:
        feedback: goalwire.Subscription[Any] = node.subscription(
            cls.Impl.FeedbackMessage, f'{action}/_action/feedback', qos=_FEEDBACK_DEPTH
        )
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(_take_statuses(statuses, action, goals, on_status))
                group.create_task(_take_feedback(feedback, action, goals, on_feedback))
        finally:
            feedback.close()
    finally:
        statuses.close()


async def _take_statuses(
    statuses: goalwire.Subscription[Any], action: str, goals: GoalTable, hear: Callable[[Goal], object]
) -> None:
    async for array in statuses:
        for goal in goals.take_statuses(action, read_reported_goals(array), monotonic(), wall_offset()):
            hear(goal)


async def _take_feedback(
    feedback: goalwire.Subscription[Any], action: str, goals: GoalTable, hear: Callable[[Goal], object]
) -> None:
    async for message in feedback:
        goal_id = bytes(message.goal_id.uuid).hex()
        hear(goals.take_feedback(action, goal_id, message.feedback, monotonic()))


async def watch_ended_goals(
    node: goalwire.Node, action: str, since: float
) -> AsyncGenerator[ReportedGoal, None]:
    """Yield each goal of an action that ends from now on, or was accepted after `since` (in s since 1970)."""
    statuses = _statuses(node, action, depth=100)
    running: set[str] = set()
    told: set[str] = set()
    try:
        async for array in statuses:
            goals = read_reported_goals(array)
            told &= {goal.goal_id for goal in goals}  # the server has forgotten the others
            for goal in goals:
                if goal.is_active:
                    running.add(goal.goal_id)
                elif goal.goal_id not in told and (goal.goal_id in running or goal.accepted >= since):
                    running.discard(goal.goal_id)
                    told.add(goal.goal_id)
                    yield goal
    finally:
        statuses.close()


async def fetch_known_goals(node: goalwire.Node, action: str, patience: float) -> list[ReportedGoal]:
    """Return the goals that the server of an action knows; a server that had no goal yet reports none.

    Waits `patience` s at most for the server's report.
    """
    statuses = _statuses(node, action)
    try:
        with suppress(TimeoutError):
            async with asyncio.timeout(patience):
                async for array in statuses:
                    return read_reported_goals(array)
    finally:
        statuses.close()
    return []


def _statuses(node: goalwire.Node, action: str, depth: int = 1) -> goalwire.Subscription[Any]:
    """Subscribe to the status topic of an action; the server's latest status message comes at once."""
    from action_msgs.msg import GoalStatusArray

    qos = goalwire.QoS(depth=depth, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
    return node.subscription(GoalStatusArray, f'{action}/_action/status', qos=qos)


# -- requests to an action's services ------------------------------------------------------------------------


def goal_request(cls: Any, goal_id: bytes, goal: Any) -> Any:
    """Return the request that sends a goal to an action of class `cls`."""
    request = cls.Impl.SendGoalService.Request(goal=goal)
    request.goal_id.uuid = list(goal_id)
    return request


def result_request(cls: Any, goal_id: str) -> Any:
    """Return the request for the result of a goal; the server answers it when the goal has ended."""
    request = cls.Impl.GetResultService.Request()
    request.goal_id.uuid = list(bytes.fromhex(goal_id))
    return request


def cancel_request(goal_id: str = '', before: float = 0.0) -> CancelGoal.Request:
    """Return the request to cancel one goal, and the goals accepted at or before a time; without both, all
    goals.

    `goal_id` is in hexadecimal digits, `before` in s since 1970.
    """
    from action_msgs.srv import CancelGoal

    request = CancelGoal.Request()
    if goal_id:
        request.goal_info.goal_id.uuid = list(bytes.fromhex(goal_id))
    request.goal_info.stamp.sec = int(before)
    request.goal_info.stamp.nanosec = int(before % 1 * 1e9)
    return request


def goals_canceling(response: Any) -> list[str]:
    """Return the ids of the goals that a server cancels, from its response to a cancel request."""
    return [bytes(goal.goal_id.uuid).hex() for goal in response.goals_canceling]
