"""goalwire fleet status: shows state, battery and goals of each robot."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.fleet.choosing import add_robots_argument, find_robots
from goalwire.apps.cli.framework.columns import align
from goalwire.apps.cli.framework.live import until_signal
from goalwire.apps.cli.framework.numbers import timeout_argument
from goalwire.apps.cli.framework.outcome import Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.fleet import RobotState

LOOK_S = 2.0
"""Seconds that a robot's topic may take to send its latest message."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet status`."""
    add_robots_argument(parser, default='*')
    timeout_argument(parser, LOOK_S, 'Seconds that a robot may take to tell its battery and its goals')


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print one line for each robot."""
    robots, _ = find_robots(arguments, nodes_only=True)

    async def look() -> Outcome:
        from goalwire.fleet import Fleet

        async with Fleet('_goalwire_fleet', robots=robots) as fleet:
            await fleet.wait_for(*robots, timeout=arguments.timeout)
            _show(await fleet.states(patience=arguments.timeout), output)
        return Outcome.OK

    return until_signal(look) if robots else Outcome.OK


def _show(states: list[RobotState], output: Output) -> None:
    if output.json:
        for each in states:
            output.data(
                {
                    'robot': each.robot,
                    'state': each.word,
                    'stopped': each.stopped,
                    'battery': each.battery,
                    'goals': each.goals,
                    'nodes': each.nodes,
                }
            )
        return
    rows = [('ROBOT', 'STATE', 'BATTERY', 'GOALS', 'NODES')]
    for each in states:
        battery = '-' if each.battery is None else f'{each.battery * 100:.0f} %'
        rows.append((each.robot, each.word, battery, str(each.goals), str(each.nodes)))
    for line in align(rows):
        output.line(line)
