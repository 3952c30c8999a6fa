"""Follows the goals of every action server that the graph shows, whoever has sent them."""

from __future__ import annotations

import asyncio
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.console.clock import wall_offset
from goalwire.apps.console.types import as_data, interface
from goalwire.errors import UnknownInterfaceError

if TYPE_CHECKING:
    from goalwire.apps.console.goal_table import GoalTable
    from goalwire.apps.console.sending import Sender


class ActionWatch:
    """The status and feedback topics of one action."""

    def __init__(
        self, node: goalwire.Node, name: str, type_name: str, goals: GoalTable, sender: Sender
    ) -> None:
        """Raises UnknownInterfaceError."""
        from action_msgs.msg import GoalStatusArray

        self.name = name
        self.type_name = type_name
        self._goals = goals
        self._sender = sender
        latched = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        feedback_type = interface(type_name).Impl.FeedbackMessage
        self._statuses = node.subscription(GoalStatusArray, f'{name}/_action/status', qos=latched)
        self._feedback: goalwire.Subscription[Any] = node.subscription(
            feedback_type, f'{name}/_action/feedback', qos=1000
        )
        loop = asyncio.get_running_loop()
        self._tasks = [
            loop.create_task(self._follow_statuses()),
            loop.create_task(self._follow_feedback()),
        ]

    async def _follow_statuses(self) -> None:
        async for array in self._statuses:
            found = [
                (
                    bytes(each.goal_info.goal_id.uuid).hex(),
                    each.status,
                    each.goal_info.stamp.sec + each.goal_info.stamp.nanosec / 1e9,
                )
                for each in array.status_list
            ]
            for goal in self._goals.take_statuses(self.name, found, monotonic(), wall_offset()):
                if not goal.is_active:
                    self._sender.fetch_result(self.type_name, goal)

    async def _follow_feedback(self) -> None:
        async for message in self._feedback:
            goal_id = bytes(message.goal_id.uuid).hex()
            self._goals.take_feedback(self.name, goal_id, as_data(message.feedback), monotonic())

    def close(self) -> None:
        """Follow no more."""
        for task in self._tasks:
            task.cancel()
        self._statuses.close()
        self._feedback.close()


class GoalWatch:
    """Keeps one ActionWatch for each action server."""

    def __init__(self, node: goalwire.Node, goals: GoalTable, sender: Sender) -> None:
        self._node = node
        self._goals = goals
        self._sender = sender
        self._watches: dict[tuple[str, str], ActionWatch] = {}

    @property
    def served(self) -> dict[str, str]:
        """Actions that have a server, with their types."""
        return dict(sorted(self._watches))

    def look(self) -> None:
        """Bring the watches up to the graph: call it when that has changed."""
        served = {
            (name, types[0])
            for name, types in self._node.graph.actions()
            if self._node.graph.publishers(f'{name}/_action/status')
        }
        for key in self._watches.keys() - served:
            self._watches.pop(key).close()
            for goal in self._goals.active(key[0]):
                self._goals.end(goal, 'UNKNOWN', 'its server has gone', monotonic())
        for name, type_name in sorted(served - self._watches.keys()):
            try:
                watch = ActionWatch(self._node, name, type_name, self._goals, self._sender)
            except (UnknownInterfaceError, goalwire.GoalwireError) as error:
                self._node.logger.warning(f"goals of '{name}' are not shown: {error}", once=True)
                continue
            self._watches[name, type_name] = watch

    def close(self) -> None:
        """Follow no more goals."""
        for watch in self._watches.values():
            watch.close()
        self._watches.clear()
