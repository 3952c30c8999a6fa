"""goalwire action attach: follows an earlier goal until it ends. Ctrl-C ends only the command."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.action.cancel import full_id
from goalwire.apps.cli.commands.action.progress import progress_argument
from goalwire.apps.cli.commands.action.run_display import RunDisplay
from goalwire.apps.cli.commands.service.call import PATIENCE_S
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.named import ACTIONS
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action attach`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('goal_id', metavar='ID', help='Id of the goal, or the beginning of the id')
    progress_argument(parser)
    parser.add_argument(
        '-t',
        '--timeout',
        metavar='S',
        type=positive,
        help='Seconds to follow the goal; then this command ends, and the goal goes on. '
        'Without, it follows the goal to its end',
    )


def run(arguments: Namespace, output: Output) -> Outcome:
    """Follow a goal; raises CommandError and goalwire's own errors."""
    name, type_name = ACTIONS.name_and_type(arguments)
    cls = lookup.interface_in_use(type_name)
    display = RunDisplay(output, feedback=True, progress=arguments.progress)

    async def follow(node: goalwire.Node) -> Outcome:
        goal_id = await full_id(node, name, arguments.goal_id, PATIENCE_S)
        client = node.action(cls, name)
        attached = client.attach(bytes.fromhex(goal_id), timeout=arguments.timeout)
        try:
            async with attached as run:
                display.say(f'Attached to goal {goal_id}')
                return await display.follow(run)
        except goalwire.ServerLostError as error:
            see = f'see: goalwire action probe {name} {goal_id}'
            raise CommandError(Outcome.SERVER_LOST, str(error), see) from None
        except (asyncio.CancelledError, goalwire.DeadlineError):
            display.clear_bar()
            tell(f'left; the goal goes on, and is stopped by: ros2 action cancel {name} {goal_id}')
            raise

    return live(follow)
