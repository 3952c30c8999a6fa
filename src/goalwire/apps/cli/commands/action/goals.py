"""ros2 action goals: lists the goals that an action server knows."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from time import time
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.named import ACTIONS
from goalwire.apps.cli.framework.numbers import timeout_argument
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.observe.clock import local_time
from goalwire.observe.goal_topics import fetch_known_goals

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.observe.goals import ReportedGoal

LOOK_S = 2.0
"""Seconds to wait for the server's status message; a server that never had a goal sends none."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action goals`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('-a', '--all', action='store_true', help='Show goals that have ended, too')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')
    timeout_argument(parser, LOOK_S, 'Seconds to wait for the server')


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print the goals that the server knows."""
    name, _ = ACTIONS.name_and_type(arguments)

    async def look(node: goalwire.Node) -> None:
        found = await fetch_known_goals(node, name, arguments.timeout)
        _print_goals([each for each in found if arguments.all or each.is_active], arguments, output)

    return live(look)


def _print_goals(found: list[ReportedGoal], arguments: Namespace, output: Output) -> None:
    if arguments.count:
        output.data(len(found)) if output.json else output.line(str(len(found)))
        return
    for each in found:
        if output.json:
            output.data({'goal_id': each.goal_id, 'status': each.status, 'accepted': each.accepted})
        else:
            when = local_time(each.accepted)
            output.line(
                f'{each.goal_id}  {each.status:9}  accepted at {when}, {time() - each.accepted:.1f} s ago'
            )
