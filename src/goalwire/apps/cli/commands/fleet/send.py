"""goalwire fleet send: sends one goal to many robots, and shows how each has ended.

The first Ctrl-C cancels all goals and waits for their ends; a second one leaves.
"""

from __future__ import annotations

import asyncio
import os
from argparse import ArgumentParser, Namespace
from collections import Counter
from pathlib import Path
from time import strftime
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.commands.fleet.looking import add_robots_argument, find_robots
from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.columns import align
from goalwire.apps.cli.framework.live import until_signal
from goalwire.apps.cli.framework.numbers import count, length, positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import STATUS_STYLES, tell
from goalwire.files import state_folder
from goalwire.fleet import Fleet, GoalReport
from goalwire.fleet.fleet import PARALLEL
from goalwire.observe.messages import as_dict
from goalwire.rules.names.robots import name_below

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.graph.graph import Graph

FIND_S = 5.0
"""Seconds that the sending node has to discover the robots, which the command discovered before."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet send`."""
    add_robots_argument(parser)
    parser.add_argument('action_name', help="Name of the action on each robot (e.g. 'navigate_to_pose')")
    parser.add_argument(
        'words',
        nargs='*',
        metavar='[TYPE] [GOAL]',
        help=f'Type of the action, which may be left out if the graph knows it; then {values.HELP}',
    )
    parser.add_argument('--stdin', action='store_true', help='Read the goal from standard input')
    parser.add_argument('--goal-file', metavar='FILE', help='Read the goal from a YAML file')
    parser.add_argument(
        '--parallel',
        metavar='N',
        type=count,
        default=PARALLEL,
        help=f'How many robots have a goal at a time (default: {PARALLEL})',
    )
    parser.add_argument(
        '--max-failures',
        metavar='N',
        type=length,
        help='After more than N failures no further goal is sent; those under way go on to their ends',
    )
    parser.add_argument(
        '-t',
        '--timeout',
        metavar='S',
        type=positive,
        help='Seconds that each goal may take; then it is cancelled',
    )
    parser.add_argument(
        '--job',
        metavar='FILE',
        type=Path,
        help='The journal of this job. The same command with the same file goes on with it: goals that have '
        'ended are not sent again (default: a new file)',
    )


_OPEN = ('NOT SENT', 'NO SERVER', 'RUNNING')
"""The statuses of goals that have not ended, so that the job can be continued."""


class _Sending:
    """One goal for many robots, and how it is shown."""

    def __init__(self, arguments: Namespace, output: Output) -> None:
        """Read the command line, and find the robots. Raises CommandError."""
        self._arguments = arguments
        self._output = output
        self._robots, graph = find_robots(arguments)
        if not self._robots:
            raise CommandError(Outcome.NOT_FOUND, 'there are no robots', 'give each robot a namespace')
        type_name, words = lookup.split_type(arguments.words, 'action')
        type_name = type_name or self._type_there(graph)
        self._cls = lookup.interface_in_use(type_name)
        if arguments.goal_file:
            words = [f'@{arguments.goal_file}']
        self._goal = self._cls.Goal()
        given = values.read_values(words, self._cls.Goal, stdin=arguments.stdin)
        self._set_stamps = values.fill(self._goal, given, type_name)
        self._reports: dict[str, GoalReport] = {}
        self.job = arguments.job or _new_job()

    def _type_there(self, graph: Graph) -> str:
        """Return the type of the action on the robots. Raises CommandError if there is none, or several."""
        name = self._arguments.action_name
        actions = graph.action_names_and_types()
        wanted = {name_below(robot, name) for robot in self._robots}
        types = sorted({each for full, found in actions for each in found if full in wanted})
        if not types:
            known = {full for full, _ in actions}
            raise lookup.unknown('action', name_below(self._robots[0], name), known, 'ros2 action list')
        return lookup.only_type(types, 'action', name, self._arguments.prog)

    async def perform(self) -> Outcome:
        """Send the goals, show their ends, and return the outcome."""
        arguments = self._arguments
        async with Fleet(f'_goalwire_fleet_{os.getpid()}', robots=self._robots) as fleet:
            await fleet.wait_for(*self._robots, timeout=FIND_S)
            for set_stamp in self._set_stamps:
                set_stamp(fleet.node.clock.now().to_msg())
            sending = asyncio.ensure_future(
                fleet.send(
                    self._cls,
                    arguments.action_name,
                    self._goal,
                    robots=self._robots,
                    parallel=arguments.parallel,
                    max_failures=arguments.max_failures,
                    timeout=arguments.timeout,
                    journal=self.job,
                    on_change=self._note,
                )
            )
            try:
                await asyncio.shield(sending)
            except asyncio.CancelledError:
                await self._cancel(sending)
                self._show_end()
                raise
        self._show_end()
        is_done = all(each.succeeded for each in self._reports.values())
        return Outcome.OK if is_done else Outcome.FAILED

    async def _cancel(self, sending: asyncio.Future[list[GoalReport]]) -> None:
        """Cancel all goals and wait for their ends, until Ctrl-C comes again."""
        tell('cancelling all goals; Ctrl-C again leaves without waiting')
        sending.cancel()
        try:
            await asyncio.shield(asyncio.wait([sending]))
        except asyncio.CancelledError:
            sending.cancel()
            await asyncio.wait([sending])
            tell('left without waiting: goals may go on')

    def _note(self, report: GoalReport) -> None:
        self._reports[report.robot] = report
        if self._output.json:
            if report.status != 'RUNNING':
                self._output.data(_as_json(report))
        elif self._output.is_terminal:
            counts = Counter(each.status for each in self._reports.values())
            text = ', '.join(f'{number} {status.lower()}' for status, number in sorted(counts.items()))
            self._output.rewrite(f'{len(self._robots)} robots: {text}')

    def _show_end(self) -> None:
        if not self._output.json:
            self._show_table()
        if any(each.status in _OPEN for each in self._reports.values()):
            tell(f'the same command goes on with this job, and sends no goal twice, with: --job {self.job}')
        elif not self._arguments.job:
            for path in self.job.parent.glob(f'{self.job.name}*'):
                path.unlink()

    def _show_table(self) -> None:
        output = self._output
        if output.is_terminal:
            output.rewrite('')
        reports = [self._reports[robot] for robot in self._robots if robot in self._reports]
        rows = [('ROBOT', 'STATUS', 'GOAL', '')]
        rows += [(each.robot, each.status, each.goal_id[:8] or '-', each.why) for each in reports]
        head, *lines = align(rows)
        output.line(head)
        for report, line in zip(reports, lines, strict=True):
            output.line(line, style=STATUS_STYLES.get(report.status, '' if report.succeeded else 'red'))
        output.flush()


def _as_json(report: GoalReport) -> dict[str, Any]:
    result = None if report.result is None else as_dict(report.result)
    return {
        'robot': report.robot,
        'status': report.status,
        'goal_id': report.goal_id,
        'result': result,
        'why': report.why,
    }


def _new_job() -> Path:
    """Return a new file for a journal in the user's own folder. Raises CommandError."""
    try:
        folder = Path(state_folder('jobs'))
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise CommandError(
            Outcome.UNAVAILABLE, f'there is no place for the journal: {error}', 'name a file with --job'
        ) from None
    return folder / f'{strftime("%Y%m%d-%H%M%S")}-{os.urandom(3).hex()}.db'


def run(arguments: Namespace, output: Output) -> Outcome:
    """Send a goal to many robots; raises CommandError and goalwire's own errors."""
    sending = _Sending(arguments, output)
    return until_signal(sending.perform)
