"""ros2 action watch: the goals of an action as they go on; a table on a terminal, else a line a change."""

from __future__ import annotations

import asyncio
import shutil
from argparse import ArgumentParser, Namespace
from time import time
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.action import progress
from goalwire.apps.cli.commands.action.goals import GoalLine, goal_lines, ran_before, status_subscription
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.messages import as_dict
from goalwire.apps.cli.framework.named import ACTIONS
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import escaped, json_text

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

REPAINT_S = 0.1
_STYLES = {
    'EXECUTING': 'cyan',
    'SUCCEEDED': 'green',
    'ABORTED': 'red',
    'CANCELED': 'yellow',
    'CANCELING': 'yellow',
}
_ENDED_SHOWN = 10
"""Goals that have ended, of which the latest stay in the table."""


def watch_arguments(parser: ArgumentParser) -> None:
    """Add what `action watch` takes after the name."""
    parser.add_argument('--progress', metavar='FIELD[/MAX]', help=progress.HELP)


class _Table:
    """What is known of the goals, and how it is shown."""

    def __init__(self, name: str, spec: str | None, output: Output) -> None:
        self._name = name
        self._spec = spec
        self._output = output
        self._goals: dict[str, GoalLine] = {}
        self._feedback: dict[str, Any] = {}
        self._progress: dict[str, progress.Progress] = {}
        self._done: dict[str, float] = {}
        self._painted = 0
        self._began = time()
        self._ran_before: set[str] | None = None
        """The goals of which the first feedback was missed; None before the first status."""
        if spec:
            progress.Progress(spec)  # a bad one is told at once

    def take_status(self, array: Any) -> None:
        """Note the goals of a status array."""
        known = self._goals
        self._goals = {goal.goal_id: goal for goal in goal_lines(array)}
        if self._ran_before is None:
            self._ran_before = ran_before(self._goals.values(), self._began)
        for goal_id in self._feedback.keys() - self._goals.keys():
            del self._feedback[goal_id]
        if self._output.is_terminal and not self._output.json:
            return
        for goal_id, goal in self._goals.items():
            if goal_id not in known or known[goal_id].status != goal.status:
                self._tell({'goal_id': goal_id, 'status': goal.status, 'accepted': goal.accepted})

    def take_feedback(self, message: Any) -> None:
        """Note the feedback of a goal."""
        goal_id = bytes(message.goal_id.uuid).hex()
        self._feedback[goal_id] = message.feedback
        told: dict[str, Any] = {'goal_id': goal_id, 'feedback': as_dict(message.feedback)}
        if self._spec:
            saw_start = goal_id not in (self._ran_before or ())
            reader = self._progress.setdefault(goal_id, progress.Progress(self._spec, saw_start=saw_start))
            done = reader.of(message.feedback)
            if done is not None:
                told['done'] = self._done[goal_id] = done
        if not self._output.is_terminal or self._output.json:
            self._tell(told)

    def _tell(self, change: dict[str, Any]) -> None:
        if self._output.json:
            self._output.data(change)
            return
        what = change.get('status') or f'feedback {json_text(change["feedback"])}'
        done = f' {change["done"] * 100:.0f} %' if 'done' in change else ''
        self._output.line(f'{change["goal_id"]} {what}{done}')
        self._output.flush()

    def paint(self) -> None:
        """Draw the table over the one before."""
        columns, rows = shutil.get_terminal_size()
        active = [goal for goal in self._goals.values() if goal.is_active]
        ended = [goal for goal in self._goals.values() if not goal.is_active][-_ENDED_SHOWN:]
        lines = [
            f'{self._name}: {len(active)} active, {len(self._goals) - len(active)} ended; Ctrl-C ends this'
        ]
        lines += [self._row(goal, columns) for goal in [*active, *ended]][: max(1, rows - 2)]
        out = [f'\x1b[{self._painted}A' if self._painted else '']
        out += [f'\r{line}\x1b[K\n' for line in lines]
        out.append('\x1b[J')
        self._output.raw(''.join(out))
        self._painted = len(lines)

    def _row(self, goal: GoalLine, columns: int) -> str:
        age = f'{max(0.0, time() - goal.accepted):6.1f} s' if goal.is_active else ' ' * 8
        row = f'{goal.goal_id[:8]}  {goal.status:9}  {age}'
        if goal.goal_id in self._done:
            row += f'  {progress.bar(self._done[goal.goal_id])}'
        if goal.goal_id in self._feedback:
            row += f'  {escaped(json_text(as_dict(self._feedback[goal.goal_id])))}'
        return self._output.styled(row[: columns - 1], _STYLES.get(goal.status, ''))


def watch(arguments: Namespace, output: Output) -> Outcome:
    """Show goals until Ctrl-C."""
    name, type_name = ACTIONS.name_and_type(arguments)
    feedback_type = lookup.interface(type_name).Impl.FeedbackMessage
    table = _Table(name, arguments.progress, output)

    async def follow(node: goalwire.Node) -> None:
        feedback = node.subscription(feedback_type, f'{name}/_action/feedback', qos=1000)
        status = status_subscription(node, name)

        async def take_statuses() -> None:
            async for array in status:
                table.take_status(array)

        async def take_feedback() -> None:
            async for message in feedback:
                table.take_feedback(message)

        async def paint() -> None:
            while True:
                table.paint()
                await asyncio.sleep(REPAINT_S)

        async with asyncio.TaskGroup() as group:
            group.create_task(take_statuses())
            group.create_task(take_feedback())
            if output.is_terminal and not output.json:
                group.create_task(paint())

    return live(follow)
