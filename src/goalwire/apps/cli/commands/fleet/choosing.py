"""Shared by the verbs of `fleet`: which robots are meant, and which of them are there."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered, robots_in
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.robots import SEE
from goalwire.errors import NoRobotError
from goalwire.rules.names.robots import check_pattern, view_of

if TYPE_CHECKING:
    from goalwire.graph.graph import Graph


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
