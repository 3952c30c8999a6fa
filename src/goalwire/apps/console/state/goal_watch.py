"""Follows the goals of every action server in the graph, from all clients."""

from __future__ import annotations

import asyncio
from time import monotonic
from typing import TYPE_CHECKING

import goalwire
from goalwire.errors import UnknownInterfaceError
from goalwire.observe.goal_topics import follow_goals
from goalwire.observe.messages import interface_class

if TYPE_CHECKING:
    from goalwire.apps.console.state.sending import Sender
    from goalwire.apps.console.state.type_watch import TypeWatch
    from goalwire.observe.goals import Goal, GoalTable


class GoalWatch:
    """Keeps one task for each action server."""

    def __init__(self, node: goalwire.Node, goals: GoalTable, sender: Sender, types: TypeWatch) -> None:
        self._node = node
        self._goals = goals
        self._sender = sender
        self._types = types
        self._tasks: dict[tuple[str, str], asyncio.Task[None]] = {}

    @property
    def served(self) -> dict[str, str]:
        """Actions that have a server, with their types."""
        return dict(sorted(self._tasks))

    def look(self) -> None:
        """Start and end tasks as the graph's servers require. Call this after changes of the graph."""
        served = {
            (name, types[0])
            for name, types in self._node.graph.actions()
            if self._node.graph.publishers(f'{name}/_action/status')
        }
        for key in self._tasks.keys() - served:
            self._tasks.pop(key).cancel()
            for goal in self._goals.active(key[0]):
                self._goals.end(goal, 'UNKNOWN', 'its server has gone', monotonic())
        for name, type_name in sorted(served - self._tasks.keys()):
            try:
                cls = interface_class(type_name)
            except UnknownInterfaceError as error:
                if not self._types.is_asking(type_name):
                    self._warn(name, error)
                continue
            self._tasks[name, type_name] = asyncio.create_task(self._follow(name, type_name, cls))

    async def _follow(self, name: str, type_name: str, cls: type) -> None:
        def fetch_result(goal: Goal) -> None:
            if not goal.is_active:
                self._sender.fetch_result(type_name, goal)

        try:
            await follow_goals(self._node, name, cls, self._goals, on_status=fetch_result)
        except goalwire.GoalwireError as error:
            self._warn(name, error)

    def _warn(self, name: str, error: Exception) -> None:
        self._node.logger.warning(f"goals of '{name}' are not shown: {error}", once=True)

    def close(self) -> None:
        """Stop following goals."""
        for task in self._tasks.values():
            task.cancel()
        self._tasks.clear()
