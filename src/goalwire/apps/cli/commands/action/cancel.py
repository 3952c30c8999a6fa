"""ros2 action cancel: cancels goals of an action, from any client."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from datetime import datetime
from time import time
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.service.call import PATIENCE_S
from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.numbers import timeout_argument
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.observe.goal_topics import cancel_request, fetch_known_goals, goals_canceling

if TYPE_CHECKING:
    from collections.abc import Iterable

    from goalwire.apps.cli.framework.output import Output

_UNITS_S = {'s': 1.0, 'm': 60.0, 'h': 3600.0}
CODES = {
    1: (Outcome.REFUSED, 'the server rejects the request'),
    2: (Outcome.NOT_FOUND, 'the server knows no such goal'),
    3: (Outcome.REFUSED, 'the goal has ended already'),
}
"""The codes of action_msgs/srv/CancelGoal for a request that cancels nothing."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action cancel`."""
    ACTIONS.name_argument(parser)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument('goal_id', nargs='?', metavar='ID', help='Id of the goal, or the beginning of the id')
    what.add_argument('--all', action='store_true', help='All goals of the action, from any client')
    what.add_argument(
        '--before',
        metavar='TIME',
        help='Goals accepted at that time or earlier: seconds since 1970, an ISO time, or how long ago '
        '(10s, 5m, 1h)',
    )
    timeout_argument(parser, PATIENCE_S, 'Seconds to wait')


def run(arguments: Namespace, output: Output) -> Outcome:
    """Cancel goals, and print their ids."""
    before = _time(arguments.before) if arguments.before else 0.0
    name, _ = ACTIONS.name_and_type(arguments)

    async def ask(node: goalwire.Node) -> Outcome:
        from action_msgs.srv import CancelGoal

        goal_id = ''
        if arguments.goal_id:
            goal_id = await full_id(node, name, arguments.goal_id, arguments.timeout, is_active=True)
        client = node.client(CancelGoal, f'{name}/_action/cancel_goal')
        response = await client.call(cancel_request(goal_id, before), timeout=arguments.timeout)
        canceling = goals_canceling(response)
        if output.json:
            output.data({'return_code': response.return_code, 'goals_canceling': canceling})
        for each in () if output.json else canceling:
            output.line(f'Canceling goal {each}')
        if canceling:
            return Outcome.OK
        outcome, problem = CODES.get(response.return_code, (Outcome.NOT_FOUND, 'there is no goal to cancel'))
        raise CommandError(outcome, f"action '{name}': {problem}", f'see: ros2 action goals {name} --all')

    return live(ask)


async def full_id(
    node: goalwire.Node, name: str, given: str, patience: float, *, is_active: bool = False
) -> str:
    """Return the full id of the goal whose id begins with `given`; with `is_active` only of a running goal.

    Raises CommandError if no goal's id begins with `given`, or if several do.
    """
    text = given.replace('-', '').lower()
    is_all_goals = text == 32 * '0'
    if not text or text.strip('0123456789abcdef') or len(text) > 32 or is_all_goals:
        raise CommandError(
            Outcome.BAD_VALUE, f"'{given}' is not an id of a goal", f'see: ros2 action goals {name}'
        )
    if len(text) == 32:
        return text
    goals = await fetch_known_goals(node, name, patience)
    return only_id(text, name, (goal.goal_id for goal in goals if goal.is_active or not is_active))


def only_id(text: str, name: str, ids: Iterable[str]) -> str:
    """Return the only id that begins with `text`; raises CommandError if no id or several begin so."""
    found = [each for each in ids if each.startswith(text)]
    if len(found) == 1:
        return found[0]
    problem = (
        f"{len(found)} goals of '{name}' begin with '{text}'" if found else f"no goal begins with '{text}'"
    )
    raise CommandError(
        Outcome.BAD_VALUE if found else Outcome.NOT_FOUND, problem, f'see: ros2 action goals {name}'
    )


def _time(text: str) -> float:
    """Read a time from the command line, and return it in s since the epoch; raises CommandError."""
    try:
        if text[-1:] in _UNITS_S:
            seconds = time() - float(text[:-1]) * _UNITS_S[text[-1]]
        elif text.replace('.', '', 1).isdigit():
            seconds = float(text)
        else:
            seconds = datetime.fromisoformat(text).timestamp()
    except ValueError:
        seconds = 0.0
    if not 0 < seconds < 2**31:
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{text}' is not a time",
            'write 1700000000.5, 2026-01-31T12:00:00, or how long ago: 10s, 5m, 1h',
        )
    return seconds
