"""ros2 action watch: shows the goals of an action: a table on a terminal, else a line for each change."""

from __future__ import annotations

import asyncio
import shutil
from argparse import ArgumentParser, Namespace
from time import time
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.action.display import bar, check_field, progress_argument
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import STATUS_STYLES, escape, json_text
from goalwire.observe.goal_topics import follow_goals
from goalwire.observe.goals import KEPT, Goal, GoalTable
from goalwire.observe.messages import as_dict
from goalwire.observe.progress import Progress

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

REPAINT_S = 0.1
ENDED_SHOWN = 10
"""How many goals that have ended stay in the table."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action watch`."""
    ACTIONS.name_argument(parser)
    progress_argument(parser)


class _Screen:
    """Shows the goals of one action: a table that is redrawn in place, or a line for each change."""

    def __init__(self, name: str, field: str | None, output: Output) -> None:
        check_field(field)
        self.goals = GoalTable(field)
        self.has_table = output.is_terminal and not output.json
        self._name = name
        self._field = field
        self._output = output
        self._painted = 0

    def show_status(self, goal: Goal) -> None:
        """Print that a goal's status has changed."""
        if not self.has_table:
            self._print({'goal_id': goal.goal_id, 'status': goal.status, 'accepted': goal.accepted})

    def show_feedback(self, goal: Goal) -> None:
        """Print a goal's feedback. Raises ProgressError if it lacks the field of `--progress`."""
        change: dict[str, Any] = {'goal_id': goal.goal_id, 'feedback': as_dict(goal.feedback)}
        if self._field:
            Progress(self._field).read(goal.feedback)
            if goal.progress is not None:
                change['done'] = goal.progress
        if not self.has_table:
            self._print(change)

    def _print(self, change: dict[str, Any]) -> None:
        if self._output.json:
            self._output.data(change)
            return
        what = change.get('status') or f'feedback {json_text(change["feedback"])}'
        done = f' {change["done"] * 100:.0f} %' if 'done' in change else ''
        self._output.line(f'{change["goal_id"]} {what}{done}')
        self._output.flush()

    async def keep_painted(self) -> None:
        """Redraw the table in place, again and again."""
        while True:
            self._paint()
            await asyncio.sleep(REPAINT_S)

    def _paint(self) -> None:
        columns, rows = shutil.get_terminal_size()
        active, number = len(self.goals.active()), len(self.goals.list_reported(self._name, KEPT))
        lines = [f'{self._name}: {active} active, {number - active} ended; Ctrl-C ends this']
        goals = self.goals.list_reported(self._name, ENDED_SHOWN)
        lines += [self._row(goal, columns) for goal in goals][: max(1, rows - 2)]
        out = [f'\x1b[{self._painted}A' if self._painted else '']
        out += [f'\r{line}\x1b[K\n' for line in lines]
        out.append('\x1b[J')
        self._output.raw(''.join(out))
        self._painted = len(lines)

    def _row(self, goal: Goal, columns: int) -> str:
        age = f'{max(0.0, time() - (goal.accepted or 0.0)):6.1f} s' if goal.is_active else ' ' * 8
        row = f'{goal.goal_id[:8]}  {goal.status:9}  {age}'
        if self._field and goal.progress is not None:
            row += f'  {bar(goal.progress)}'
        if goal.feedback is not None:
            row += f'  {escape(json_text(as_dict(goal.feedback)))}'
        return self._output.style(row[: columns - 1], STATUS_STYLES.get(goal.status, ''))


def run(arguments: Namespace, output: Output) -> Outcome:
    """Show goals until Ctrl-C."""
    name, type_name = ACTIONS.name_and_type(arguments)
    cls = lookup.interface_in_use(type_name)
    screen = _Screen(name, arguments.progress, output)

    async def follow(node: goalwire.Node) -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(
                follow_goals(node, name, cls, screen.goals, screen.show_status, screen.show_feedback)
            )
            if screen.has_table:
                group.create_task(screen.keep_painted())

    return live(follow)
