"""ros2 action goals, and goalwire action attach and probe: goals that were sent before."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from time import time
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.action.cancel import full_id
from goalwire.apps.cli.commands.action.display import RunDisplay, progress_argument, yaml_text
from goalwire.apps.cli.commands.service.call import PATIENCE_S
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.numbers import positive, timeout_argument
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.observe.clock import local_time
from goalwire.observe.goal_topics import fetch_known_goals
from goalwire.observe.messages import as_dict

if TYPE_CHECKING:
    from typing import Any

    from goalwire.apps.cli.framework.output import Output
    from goalwire.observe.goals import ReportedGoal


LOOK_S = 2.0
"""Seconds to wait for the server's status message; a server that never had a goal sends none."""


def add_list_goals_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action goals`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('-a', '--all', action='store_true', help='Show goals that have ended, too')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')
    timeout_argument(parser, LOOK_S, 'Seconds to wait for the server')


def list_goals(arguments: Namespace, output: Output) -> Outcome:
    """Print the goals that the server knows."""
    name, _ = ACTIONS.name_and_type(arguments)

    async def look(node: goalwire.Node) -> None:
        found = await fetch_known_goals(node, name, arguments.timeout)
        _print_goals([each for each in found if arguments.all or each.is_active], arguments, output)

    return live(look)


def _print_goals(found: list[ReportedGoal], arguments: Namespace, output: Output) -> None:
    if arguments.count:
        output.show(len(found), str(len(found)))
        return
    for each in found:
        if output.json:
            output.data({'goal_id': each.goal_id, 'status': each.status, 'accepted': each.accepted})
        else:
            when = local_time(each.accepted)
            output.line(
                f'{each.goal_id}  {each.status:9}  accepted at {when}, {time() - each.accepted:.1f} s ago'
            )


def add_attach_arguments(parser: ArgumentParser) -> None:
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


def attach(arguments: Namespace, output: Output) -> Outcome:
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


_PATIENCE_S = 10.0


def add_probe_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action probe`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('goal_id', metavar='ID', help='Id of the goal, or the beginning of the id')
    timeout_argument(parser, _PATIENCE_S, 'Seconds to ask the server')


def probe(arguments: Namespace, output: Output) -> Outcome:
    """Print the state of a goal; raises CommandError if the server does not know it or does not answer."""
    name, type_name = ACTIONS.name_and_type(arguments)
    cls = lookup.interface_in_use(type_name)

    async def ask(node: goalwire.Node) -> Outcome:
        goal_id = await full_id(node, name, arguments.goal_id, arguments.timeout)
        found = await node.action(cls, name).probe(bytes.fromhex(goal_id), timeout=arguments.timeout)
        _show(found, goal_id, output)
        if found.state is goalwire.GoalState.UNKNOWN:
            see = 'look at the robot before the goal is sent again'
            raise CommandError(Outcome.NOT_FOUND, f'the server does not have the goal: {found.why}', see)
        refuse_unclear(found)
        return Outcome.OK

    return live(ask)


def refuse_unclear(found: goalwire.GoalProbe[Any]) -> None:
    """Raise CommandError if the goal was executed in part, or if nobody can tell how it stands."""
    if found.state is goalwire.GoalState.SERVER_DIED:
        see = 'look at the robot: the goal was executed in part'
        raise CommandError(Outcome.NOT_FOUND, f'the goal has no end: {found.why}', see)
    if found.state is goalwire.GoalState.CANNOT_TELL:
        see = 'ask again later, and do not send the goal again'
        raise CommandError(Outcome.FAILED, f'nobody can tell how the goal stands: {found.why}', see)


def _show(found: goalwire.GoalProbe[Any], goal_id: str, output: Output) -> None:
    if output.json:
        result = None if found.result is None else as_dict(found.result)
        output.data(
            {
                'goal_id': goal_id,
                'state': found.state.value,
                'status': found.status.name,
                'result': result,
                'why': found.why,
            }
        )
        return
    output.line(f'{goal_id}: {found.state.value}, {found.status.name}')
    if found.result is not None:
        output.block(f'Result:\n    {yaml_text(found.result)}')
