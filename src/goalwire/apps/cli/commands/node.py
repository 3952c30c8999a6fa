"""ros2 node: list, info."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.nodes import node_names, one_node
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('-a', '--all', action='store_true', help='Show hidden nodes, too')
    parser.add_argument(
        '-c', '--count-nodes', '--count', action='store_true', help='Show only how many there are'
    )


def _list(arguments: Namespace, output: Output) -> None:
    with discovered(arguments) as graph:
        names = node_names(graph, include_hidden=arguments.all)
    if arguments.count_nodes:
        output.show(len(names), str(len(names)))
        return
    if len(set(names)) < len(names):
        tell(
            'WARNING: Be aware that there are nodes in the graph that share an exact name, '
            'which can have unintended side effects.'
        )
    for name in names:
        output.show({'name': name}, name)


def _info_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('node_name', help="Name of the node (e.g. '/talker')")
    parser.add_argument(
        '--include-hidden', action='store_true', help='Show hidden topics, services and actions, too'
    )


def _info(arguments: Namespace, output: Output) -> None:
    with discovered(arguments) as graph:
        name = one_node(graph, arguments.node_name)
    number = sum(node.node.qualified == name for node in graph.nodes())
    if number > 1:
        tell(
            f'There are {number} nodes in the graph with the exact name "{name}". '
            'You are seeing information about only one of them.'
        )
    found = sections(graph, name, include_hidden=arguments.include_hidden)
    if output.json:
        shown = {title.lower().replace(' ', '_'): dict(names) for title, names in found}
        output.data({'name': name, 'nodes_of_that_name': number, **shown})
        return
    output.line(name)
    for title, names in found:
        output.line(f'  {title}:')
        for each, types in names:
            output.line(f'    {each}: {", ".join(types)}')
        if not names:
            output.line()


def sections(graph: Graph, full_name: str, *, include_hidden: bool) -> list[tuple[str, NamesAndTypes]]:
    """Return the endpoints of a node by the titles of `node info`."""
    from goalwire.graph.names import without_hidden
    from goalwire.transport.contract import EndpointKind

    namespace, _, name = full_name.rpartition('/')
    node = name, namespace or '/'
    found = [
        ('Subscribers', graph.names_and_types_by_node(EndpointKind.SUBSCRIPTION, *node)),
        ('Publishers', graph.names_and_types_by_node(EndpointKind.PUBLISHER, *node)),
        ('Service Servers', graph.names_and_types_by_node(EndpointKind.SERVICE, *node)),
        ('Service Clients', graph.names_and_types_by_node(EndpointKind.CLIENT, *node)),
        ('Action Servers', graph.action_servers_by_node(*node)),
        ('Action Clients', graph.action_clients_by_node(*node)),
    ]
    return [(title, names if include_hidden else without_hidden(names)) for title, names in found]


NOUN = Noun(
    'node',
    'Various node related sub-commands',
    (
        Verb('info', 'Output information about a node', _info, _info_arguments),
        Verb('list', 'Output a list of available nodes', _list, _list_arguments),
    ),
)
