"""goalwire fleet list: lists the robots that are there. Only nodes are discovered, so it is quick."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.fleet.choosing import add_robots_argument, find_robots
from goalwire.apps.cli.framework.output import tell
from goalwire.rules.names.robots import robot_of

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet list`."""
    add_robots_argument(parser, default='*')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')


def run(arguments: Namespace, output: Output) -> None:
    """Print the names of the robots, one a line."""
    robots, graph = find_robots(arguments, nodes_only=True)
    if arguments.count:
        output.data(len(robots)) if output.json else output.line(str(len(robots)))
        return
    nodes = Counter(robot_of(node.node.namespace) for node in graph.nodes())
    for robot in robots:
        output.data({'robot': robot, 'nodes': nodes[robot]}) if output.json else output.line(robot)
    if not robots and not output.json:
        tell('no node has a namespace, so there are no robots')
