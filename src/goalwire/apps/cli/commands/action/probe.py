"""goalwire action probe: asks the server for the state of an earlier goal, and changes nothing."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.action.cancel import full_id
from goalwire.apps.cli.commands.action.run_display import yaml_text
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.named import ACTIONS
from goalwire.apps.cli.framework.numbers import timeout_argument
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.observe.messages import as_dict

if TYPE_CHECKING:
    from typing import Any

    from goalwire.apps.cli.framework.output import Output

_PATIENCE_S = 10.0


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action probe`."""
    ACTIONS.name_argument(parser)
    parser.add_argument('goal_id', metavar='ID', help='Id of the goal, or the beginning of the id')
    timeout_argument(parser, _PATIENCE_S, 'Seconds to ask the server')


def run(arguments: Namespace, output: Output) -> Outcome:
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
        if found.state is goalwire.GoalState.SERVER_DIED:
            see = 'look at the robot: the goal was executed in part'
            raise CommandError(Outcome.NOT_FOUND, f'the goal has no end: {found.why}', see)
        if found.state is goalwire.GoalState.CANNOT_TELL:
            see = 'ask again later, and do not send the goal again'
            raise CommandError(Outcome.FAILED, f'nobody can tell how the goal stands: {found.why}', see)
        return Outcome.OK

    return live(ask)


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
