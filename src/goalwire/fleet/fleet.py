"""The robots of a fleet, for programs of `async def` functions."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeVar

from goalwire.aio import Node
from goalwire.aio.entity import message_of
from goalwire.entities.type_support import action_support
from goalwire.errors import NoRobotError
from goalwire.fleet.job import GoalReport, Job
from goalwire.fleet.state import RobotState, look_at
from goalwire.rules.names.robots import name_below, robot_of, view_of

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from goalwire.entities.actions.types import ActionClass

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')

PARALLEL = 20
"""How many robots have a goal at a time by default."""
PATIENCE_S = 2.0
"""Seconds that a robot's topic may take to send its latest message."""


class Fleet:
    """Some robots, each in a namespace of its own: `async with Fleet('dispatch') as fleet:`, once.

    Only these robots are discovered, so that the cost grows with them and not with all robots there are.
    """

    def __init__(self, name: str, *, robots: str | Iterable[str] = '*', domain: int | None = None) -> None:
        """Prepare the fleet; entering its block opens it. `robots` are names or patterns such as 'a*'; `name`
        is that of the node.

        Raises ValueError for a bad pattern.
        """
        self._view = view_of(robots)
        self._node = Node(name, domain=domain, robots=self._view.patterns)

    async def __aenter__(self) -> Self:
        """Join the graph. Raises as entering a Node does."""
        await self._node.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._node.__aexit__(kind, error, trace)

    @property
    def node(self) -> Node:
        """The node, which sees these robots alone; for topics, services and actions of one robot."""
        return self._node

    @staticmethod
    def name_on(robot: str, name: str) -> str:
        """Return the full name of a robot's topic, service or action. An absolute name stays as it is."""
        return name_below(robot, name)

    def robots(self, pattern: str = '*') -> list[str]:
        """Return the sorted names of the robots that are there. Raises ValueError for a bad pattern."""
        wanted = view_of(pattern)
        found = {robot_of(name.rpartition('/')[0]) for name in self._node.graph.nodes()}
        return sorted(robot for robot in found if wanted.has(robot) and self._view.has(robot))

    async def wait_for(self, *robots: str, timeout: float | None = None) -> None:
        """Wait until each of these robots has a node. Raises NoRobotError after `timeout` s."""
        changes = self._node.graph.changes()
        try:
            async with asyncio.timeout(timeout):
                while not set(robots) <= set(self.robots()):
                    await anext(changes)
        except TimeoutError:
            missing = next(robot for robot in robots if robot not in self.robots())
            raise NoRobotError(missing, self.robots()) from None
        finally:
            changes.close()

    async def state(self, robot: str, *, patience: float = PATIENCE_S) -> RobotState:
        """Return the state of a robot, in `patience` s at most. Raises NoRobotError."""
        if robot not in self.robots():
            raise NoRobotError(robot, self.robots())
        return await look_at(self._node, robot, patience)

    async def states(self, pattern: str = '*', *, patience: float = PATIENCE_S) -> list[RobotState]:
        """Return the states of the robots that are there, in `patience` s at most."""
        robots = self.robots(pattern)
        return await asyncio.gather(*(look_at(self._node, robot, patience) for robot in robots))

    async def send(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        action: str,
        goal: GoalT | None = None,
        /,
        *,
        robots: str | Iterable[str] = '*',
        parallel: int = PARALLEL,
        max_failures: int | None = None,
        timeout: float | None = None,
        journal: str | Path | None = None,
        on_change: Callable[[GoalReport], object] = lambda _report: None,
        **fields: object,
    ) -> list[GoalReport]:
        """Send one goal to each of these robots, and return a report of each when all goals have ended.

        `robots` are a pattern, or names. At most `parallel` robots have a goal at a time, each for `timeout`
        s at most. After more than `max_failures` failures no further goals are sent. `on_change` is called
        with each report that is new.

        With a `journal`, a file, the same job may be sent again, also after a crash: goals that have ended
        keep their results, goals that run are followed, and only the others are sent. If the task is
        cancelled, the goals are cancelled, and their ends are waited for.

        Raises NoRobotError if no robot is there, or a named one is not; JournalError; MissionIdTaken if the
        journal belongs to another goal; ValueError for `parallel` below 1 or a bad pattern.
        """
        if parallel < 1:
            raise ValueError(f'parallel is a number from 1 on, not {parallel}')
        goal_type: type = action_support(action_type).cls.Goal  # type: ignore[attr-defined]
        message = message_of(goal_type, goal, fields)
        wanted = self._choose(robots)
        with ExitStack() as stack:
            if journal is None:
                journal = Path(stack.enter_context(TemporaryDirectory())) / 'job.db'
            job = Job(
                self._node,
                action_type,
                action,
                message,
                journal=Path(journal),
                parallel=parallel,
                max_failures=max_failures,
                timeout=timeout,
                on_change=on_change,
            )
            return await job.run(wanted)

    def _choose(self, robots: str | Iterable[str]) -> list[str]:
        """Return the robots of a pattern or of names. Raises NoRobotError."""
        there = self.robots()
        patterns = view_of(robots).patterns
        for each in patterns:
            if not any(view_of(each).has(robot) for robot in there):
                raise NoRobotError(each, there)
        return [robot for robot in there if view_of(patterns).has(robot)]
