"""goalwire fleet list and status: the robots that are there, and how each is."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections import Counter
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.columns import align
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered, robots_in
from goalwire.apps.cli.framework.live import until_signal
from goalwire.apps.cli.framework.numbers import timeout_argument
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.robots import SEE
from goalwire.errors import NoRobotError
from goalwire.rules.names.robots import check_pattern, robot_of, view_of

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.fleet import RobotState
    from goalwire.graph.graph import Graph


def add_list_robots_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet list`."""
    add_robots_argument(parser, default='*')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')


def list_robots(arguments: Namespace, output: Output) -> None:
    """Print the names of the robots, one a line."""
    robots, graph = find_robots(arguments, nodes_only=True)
    if arguments.count:
        output.show(len(robots), str(len(robots)))
        return
    nodes = Counter(robot_of(node.node.namespace) for node in graph.nodes())
    for robot in robots:
        output.show({'robot': robot, 'nodes': nodes[robot]}, robot)
    if not robots and not output.json:
        tell('no node has a namespace, so there are no robots')


LOOK_S = 2.0
"""Seconds that a robot's topic may take to send its latest message."""


def add_show_status_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet status`."""
    add_robots_argument(parser, default='*')
    timeout_argument(parser, LOOK_S, 'Seconds that a robot may take to tell its battery and its goals')


def show_status(arguments: Namespace, output: Output) -> Outcome:
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


def pattern(text: str) -> str:
    """Read a pattern of names of robots; raises ArgumentTypeError."""
    try:
        return check_pattern(text)
    except ValueError as error:
        raise ArgumentTypeError(str(error)) from None


def add_robots_argument(parser: ArgumentParser, *, default: str | None = None) -> None:
    """Add --robots, and the flags of every command that looks at the graph."""
    add_graph_arguments(parser)
    parser.add_argument(
        '-r',
        '--robots',
        metavar='PATTERN',
        type=pattern,
        default=default,
        required=default is None,
        help="The robots that are meant: a name, or a pattern in quotes such as 'a*'; '*' stands for all"
        + (' (default)' if default else ''),
    )


def find_robots(arguments: Namespace, *, nodes_only: bool = False) -> tuple[list[str], Graph]:
    """Return the robots that match --robots, and their graph.

    Raises CommandError if no robot matches; '*' may match none.
    """
    view = view_of(arguments.robots, nodes_only=nodes_only)
    with discovered(arguments, view=view, whole=True) as graph:
        robots = robots_in(graph)
    if not robots and arguments.robots != '*':
        with discovered(arguments, view=view_of('*', nodes_only=True), whole=True) as everybody:
            error = NoRobotError(arguments.robots, robots_in(everybody))
        raise CommandError(Outcome.NOT_FOUND, str(error), f'see: {SEE}')
    return robots, graph
