"""One goal for each of many robots, with a journal, so that a repeated job runs no goal twice.

The goal of each robot is a durable mission of one step: its intent is on the disk before it is sent, and its
id follows from the journal. A job that is run again with the same journal takes the results of the goals that
have ended, follows those that run, and sends those that were never sent.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from goalwire.cdr import codec
from goalwire.cdr.type_hash import type_hash
from goalwire.errors import (
    CallError,
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalRefused,
    MissionIdTaken,
    MissionStopped,
    NoServerError,
    StepLost,
)
from goalwire.missions import MissionRun, MissionState, Runner, Steps, mission
from goalwire.missions.outcomes import outcome_of
from goalwire.records import record
from goalwire.rules.missions.entries import EntryKind, digest_of
from goalwire.rules.names.robots import name_below

if TYPE_CHECKING:
    from pathlib import Path

    from goalwire.aio import Node
    from goalwire.rules.missions.entries import Json

SERVER_S = 5.0
"""Seconds that a robot's action server may take to appear; nothing is sent before."""

_STATUSES: tuple[tuple[type[Exception], str], ...] = (
    (GoalAborted, 'ABORTED'),
    (GoalCanceled, 'CANCELED'),
    (GoalRefused, 'REFUSED'),
    (NoServerError, 'NO SERVER'),
    (DeadlineError, 'TIMEOUT'),
    (StepLost, 'LOST'),
)


@record
class GoalReport:
    """The goal of one robot."""

    robot: str
    status: str
    """SUCCEEDED, ABORTED or CANCELED, as the server says; REFUSED, 'NO SERVER' or 'NOT SENT' if it did not
    run; TIMEOUT; LOST if it may have run and nobody can tell; RUNNING before its end."""
    goal_id: str = ''
    """The goal's id in hexadecimal digits; '' if nothing was sent."""
    result: Any = None
    """The result's message, if the server has sent one."""
    why: str = ''
    """The reason, if the goal did not succeed."""

    @property
    def succeeded(self) -> bool:
        """True if the goal has succeeded."""
        return self.status == 'SUCCEEDED'

    @property
    def failed(self) -> bool:
        """True if the robot was asked, and the goal has not succeeded."""
        return self.status not in {'SUCCEEDED', 'RUNNING', 'NOT SENT'}


def _ignore(_report: GoalReport) -> None:
    pass


class Job:
    """The goals of one action for many robots."""

    def __init__(
        self,
        node: Node,
        action_type: Any,
        action: str,
        goal: Any,
        *,
        journal: Path,
        parallel: int,
        max_failures: int | None,
        timeout: float | None,
        on_change: Callable[[GoalReport], object] = _ignore,
    ) -> None:
        """`goal` is a message. `on_change` is called with each report that is new."""
        self._node = node
        self._type = action_type
        self._action = action
        self._goal = goal
        self._journal = journal
        self._timeout = timeout
        self._digest = digest_of(type_hash(type(goal)), codec.encode(goal), repr(timeout))
        self._room = asyncio.Semaphore(parallel)
        self._most_failures = max_failures
        self._on_change = on_change
        self._failures = 0
        self._definition = mission(name='fleet goal', resume='auto')(self._carry_out)
        self.reports: dict[str, GoalReport] = {}
        """The reports so far, by the robots' names."""

    async def run(self, robots: Iterable[str]) -> list[GoalReport]:
        """Send the goal to the robots, and return a report of each, in their order.

        If the task is cancelled, every goal is cancelled, and the task waits for their ends. If the task is
        cancelled again, it ends at once, and goals may go on. Raises JournalError, MissionIdTaken if the
        journal belongs to another goal.
        """
        wanted = list(robots)
        async with Runner(self._node, self._journal, missions=[self._definition]) as runner:
            try:
                async with asyncio.TaskGroup() as group:
                    for robot in wanted:
                        group.create_task(self._send(runner, robot))
            except asyncio.CancelledError:
                await self._cancel(runner)
                raise
            except BaseExceptionGroup as errors:
                raise errors.exceptions[0] from None
            finally:
                for robot in wanted:
                    if robot not in self.reports:
                        self._tell(GoalReport(robot, 'NOT SENT'))
        return [self.reports[robot] for robot in wanted]

    async def _send(self, runner: Runner, robot: str) -> None:
        async with self._room:
            if self._most_failures is not None and self._failures > self._most_failures:
                self._tell(GoalReport(robot, 'NOT SENT', why=f'{self._failures} goals have failed'))
                return
            if not await runner.has(robot) and not await self._has_server(runner, robot):
                self._tell(GoalReport(robot, 'NO SERVER', why=f'no server within {SERVER_S:.0f} s'))
                return
            run = await self._start(runner, robot)
            self._tell(GoalReport(robot, 'RUNNING', run.goal_id(0, 1).hex()))
            await run.ended.wait()
            self._tell(self._report(robot, run))

    async def _start(self, runner: Runner, robot: str) -> MissionRun:
        """Begin the mission of a robot, or continue it. Raises MissionIdTaken."""
        try:
            return await runner.start(self._definition, robot, self._action, self._digest, id=robot)
        except MissionIdTaken:
            raise MissionIdTaken(
                f"the journal '{self._journal}' belongs to another action, goal or timeout: name another file"
            ) from None

    async def _has_server(self, runner: Runner, robot: str) -> bool:
        # The robot's mission uses the same client. A client of its own would double the cost of a large job.
        client = runner.clients.action(self._type, name_below(robot, self._action))
        try:
            await client.wait_for_server(timeout=SERVER_S)
        except NoServerError:
            return False
        return True

    def _tell(self, report: GoalReport) -> None:
        self.reports[report.robot] = report
        self._failures += report.failed
        self._on_change(report)

    async def _cancel(self, runner: Runner) -> None:
        """Cancel the goals under way, and wait for their ends."""
        runs = {run.row.id: run for run in runner.missions() if run.state.is_open}
        for robot in runs:
            await runner.cancel(robot)
        for robot, run in runs.items():
            await run.ended.wait()
            self._tell(self._report(robot, run))

    async def _carry_out(self, steps: Steps, robot: str, action: str, _digest: str) -> Json:
        """The mission of one robot. Errors become values, too: the journal keeps a mission's value."""
        drive = steps.action(self._type, name_below(robot, action), if_lost='fail')
        try:
            await drive.call(self._goal, timeout=self._timeout)
        except MissionStopped as stop:
            known = 'CANCELED' if 'may go on' not in str(stop) else 'LOST'
            return {'status': known, 'why': str(stop)}
        except (CallError, StepLost) as error:
            status = next((word for kind, word in _STATUSES if isinstance(error, kind)), 'FAILED')
            return {'status': status, 'why': str(error)}
        return {'status': 'SUCCEEDED', 'why': ''}

    def _report(self, robot: str, run: MissionRun) -> GoalReport:
        """Return the report of a mission that has ended."""
        goal_id = run.goal_id(0, 1).hex()
        value = run.result
        if not isinstance(value, dict):
            status = 'CANCELED' if run.state is MissionState.CANCELED else 'FAILED'
            return GoalReport(robot, status, goal_id, why=str(run.failure or run.why))
        ended = [entry for entry in run.entries_of(0) if entry.kind is EntryKind.ENDED]
        outcome = outcome_of(ended[-1], self._type.Result) if ended else None
        result = None if outcome is None else getattr(outcome.error, 'result', outcome.value)
        return GoalReport(robot, str(value['status']), goal_id, result, str(value['why']))
