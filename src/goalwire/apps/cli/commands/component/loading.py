"""Containers of components, and the request to load a component into one."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import discovered
from goalwire.apps.cli.framework.nodes import node_names
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    import goalwire
    from goalwire.graph.graph import Graph

LOAD_S = 30.0
"""Seconds that a container may take to load a component; importing its modules takes most of them."""
SEVERITIES = {'debug': 10, 'info': 20, 'warn': 30, 'error': 40, 'fatal': 50}
"""The levels of rcl_interfaces/msg/Log by the names that `--log-level` takes."""
_SERVICES = {
    'load_node': 'composition_interfaces/srv/LoadNode',
    'unload_node': 'composition_interfaces/srv/UnloadNode',
    'list_nodes': 'composition_interfaces/srv/ListNodes',
}


def add_container_argument(parser: ArgumentParser, *, optional: bool = False) -> None:
    """Add the argument for the name of a container."""
    parser.add_argument(
        'container_node_name', nargs='?' if optional else None, help='Name of the container node'
    )


def add_component_arguments(parser: ArgumentParser) -> None:
    """Add the arguments for a component and its settings."""
    parser.add_argument('package_name', help='Package that has the component')
    parser.add_argument('plugin_name', help="The component's type, as `component types` shows it")
    parser.add_argument('-n', '--node-name', help="The component's node name")
    parser.add_argument('--node-namespace', help="The component's namespace")
    parser.add_argument('--log-level', choices=SEVERITIES, type=str.lower, help="The component's log level")
    parser.add_argument(
        '-r', '--remap-rule', action='append', dest='remap_rules', default=[], help="A rule 'from:=to'"
    )
    parser.add_argument(
        '-p', '--parameter', action='append', dest='parameters', default=[], help="A parameter 'name:=value'"
    )
    parser.add_argument(
        '-e',
        '--extra-argument',
        action='append',
        dest='extra_arguments',
        default=[],
        help="An argument for the container, 'name:=value'",
    )
    parser.add_argument(
        '--service-timeout',
        metavar='N',
        type=positive,
        default=LOAD_S,
        help=f'Seconds that the container may take ({LOAD_S:.0f})',
    )


def container_names(graph: Graph) -> list[str]:
    """Return the nodes that load, unload and list components, sorted."""
    serving = dict(graph.service_names_and_types())
    return [
        name
        for name in node_names(graph, include_hidden=True)
        if all(type_ in serving.get(f'{name}/_container/{verb}', ()) for verb, type_ in _SERVICES.items())
    ]


def find_container(arguments: Namespace) -> str:
    """Return the container that the user named; raises CommandError if it is not in the graph."""
    name = lookup.full_name(arguments.container_node_name, 'container')
    with discovered(arguments, lambda graph: name in container_names(graph)) as graph:
        known = container_names(graph)
    if name not in known:
        raise lookup.unknown('container', name, known, 'ros2 component list')
    return name


async def load_component(node: goalwire.Node, container: str, arguments: Namespace) -> Any:
    """Return the LoadNode.Response of a container that has loaded a component; raises CommandError."""
    from composition_interfaces.srv import LoadNode

    request = LoadNode.Request(
        package_name=arguments.package_name,
        plugin_name=arguments.plugin_name,
        node_name=arguments.node_name or '',
        node_namespace=arguments.node_namespace or '',
        log_level=SEVERITIES.get(arguments.log_level, 0),
        remap_rules=arguments.remap_rules,
        parameters=[_parameter(text, '--parameter') for text in arguments.parameters],
        extra_arguments=[_parameter(text, '--extra-argument') for text in arguments.extra_arguments],
    )
    client = node.client(LoadNode, f'{container}/_container/load_node')
    response: Any = await client.call(request, timeout=arguments.service_timeout)
    if not response.success:
        raise CommandError(
            Outcome.REFUSED,
            f"the container '{container}' did not load '{arguments.plugin_name}': "
            f'{lookup.one_line(response.error_message)}',
            'see: ros2 component types',
        )
    return response


def _parameter(text: str, flag: str) -> Any:
    """Return the Parameter message of 'name:=value'; raises CommandError."""
    from rcl_interfaces.msg import Parameter

    from goalwire.entities.parameters.files import parameter_value_from_text

    name, separator, value = text.partition(':=')
    if not separator or not name:
        raise CommandError(
            Outcome.BAD_VALUE, f"{flag} '{text}' is not a parameter", f'write: {flag} name:=value'
        )
    return Parameter(name=name, value=parameter_value_from_text(value))
