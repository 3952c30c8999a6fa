"""Finds a node, and calls the services that every node has, such as those for parameters."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import discovered
from goalwire.apps.cli.framework.numbers import positive, seconds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from goalwire.graph.graph import Graph

CALL_S = 5.0
"""How long a service of a node may take to answer by default."""


def is_hidden(full_name: str) -> bool:
    """Return whether ROS 2's tools show a node on request only."""
    return full_name.rpartition('/')[2].startswith('_')


def node_names(graph: Graph, *, include_hidden: bool) -> list[str]:
    """Return the sorted names of the nodes; a name that several nodes share occurs several times."""
    names = sorted(node.node.qualified for node in graph.nodes())
    return [name for name in names if include_hidden or not is_hidden(name)]


def one_node(graph: Graph, given: str) -> str:
    """Return the full name of a node; raises CommandError if the node is not in the graph."""
    name = lookup.full_name(given, 'node')
    known = node_names(graph, include_hidden=True)
    if name not in known:
        raise lookup.unknown('node', name, filter(lambda each: not is_hidden(each), known), 'ros2 node list')
    return name


def add_node_argument(parser: ArgumentParser, *, optional: bool = False) -> None:
    """Add the arguments for a node's name, and for hidden nodes."""
    parser.add_argument(
        'node_name', nargs='?' if optional else None, help="Name of the node (e.g. '/talker')"
    )
    parser.add_argument(
        '--include-hidden-nodes', '-a', '--all', action='store_true', help='Consider hidden nodes as well'
    )


def add_timeout_argument(parser: ArgumentParser) -> None:
    """Add the option for the number of seconds to wait for a node."""
    parser.add_argument(
        '--timeout',
        metavar='N',
        type=seconds,
        default=0.0,
        help='Seconds to wait until the node is there (default: no wait)',
    )
    parser.add_argument(
        '--service-timeout',
        metavar='N',
        type=positive,
        default=CALL_S,
        help=f'Seconds for its answer ({CALL_S:.0f})',
    )


def find_node(arguments: Namespace) -> str:
    """Return the full name of the node that the user named; raises CommandError if it is not in the graph."""
    name = lookup.full_name(arguments.node_name, 'node')

    def is_there(graph: Graph) -> bool:
        return any(node.node.qualified == name for node in graph.nodes())

    with discovered(arguments, is_there, wait=getattr(arguments, 'timeout', 0.0) or 0.0) as graph:
        return one_node(graph, name)


async def call(
    node: goalwire.Node, srv_type: Any, service: str, arguments: Namespace, fields: Mapping[str, Any]
) -> Any:
    """Call a service of a node; raises goalwire's own errors."""
    timeout = getattr(arguments, 'service_timeout', None) or CALL_S
    return await node.client(srv_type, service).call(srv_type.Request(**fields), timeout=timeout)
