"""ros2 component: list, load, unload, types; standalone is in component_standalone.py."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.component import standalone as component_standalone
from goalwire.apps.cli.commands.component.loading import (
    add_component_arguments,
    add_container_argument,
    container_names,
    find_container,
    load_component,
)
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.nodes import call
from goalwire.apps.cli.framework.numbers import count
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_CPP_RESOURCE = 'rclcpp_components'


# -- types ---------------------------------------------------------------------------------------------------


def _types_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('package_name', nargs='?', help='Package to show (default: all)')


def _types(arguments: Namespace, output: Output) -> None:
    found = _registered_types()
    wanted = arguments.package_name
    if wanted is not None and wanted not in found:
        raise CommandError(
            Outcome.NOT_FOUND, f"the package '{wanted}' has no components", 'see: ros2 component types'
        )
    for package in sorted(found) if wanted is None else [wanted]:
        if output.json:
            output.data({'package': package, 'types': found[package]})
            continue
        if wanted is None:
            output.line(package)
        for name in found[package]:
            output.line(name if wanted is not None else f'  {name}')


def _registered_types() -> dict[str, list[str]]:
    """Return C++ components from the ament index and Python components, by their packages."""
    from importlib.metadata import entry_points

    from ament_index_python.resources import get_resource, get_resources

    from goalwire.launching.packages import COMPONENTS, source_components, source_packages

    found: dict[str, list[str]] = {}
    for package in get_resources(_CPP_RESOURCE):
        content, _ = get_resource(_CPP_RESOURCE, package)
        found[package] = [line.split(';')[0] for line in content.splitlines() if line.strip()]
    python = [(point.dist.name, point.name) for point in entry_points(group=COMPONENTS) if point.dist]
    python += [(package, point.name) for package in source_packages() for point in source_components(package)]
    for package, name in python:
        names = found.setdefault(package, [])
        if name not in names:
            names.append(name)
    return found


# -- list ----------------------------------------------------------------------------------------------------


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_container_argument(parser, optional=True)
    parser.add_argument('--containers-only', action='store_true', help='List only the containers')


def _list(arguments: Namespace, output: Output) -> Outcome:
    if arguments.container_node_name is not None:
        containers = [find_container(arguments)]
    else:
        with discovered(arguments, whole=True) as graph:
            containers = container_names(graph)
    if arguments.containers_only:
        for name in containers:
            output.show({'container': name}, name)
        return Outcome.OK

    async def show(node: goalwire.Node) -> Outcome:
        outcome = Outcome.OK
        for name in containers:
            try:
                await _show_components(node, name, arguments, output)
            except goalwire.CallError as error:
                if arguments.container_node_name is not None:
                    raise
                tell(f"the container '{name}' does not list its components: {error}")
                outcome = Outcome.SERVER_LOST
        return outcome

    return live(show)


async def _show_components(node: goalwire.Node, name: str, arguments: Namespace, output: Output) -> None:
    from composition_interfaces.srv import ListNodes

    response = await call(node, ListNodes, f'{name}/_container/list_nodes', arguments, {})
    components = list(zip(response.unique_ids, response.full_node_names, strict=False))
    if output.json:
        nodes = [{'id': each, 'node': full_name} for each, full_name in components]
        output.data({'container': name, 'components': nodes})
        return
    is_one_of_all = arguments.container_node_name is None
    if is_one_of_all:
        output.line(name)
    for unique_id, full_name in components:
        output.line(f'{"  " if is_one_of_all else ""}{unique_id}  {full_name}')


# -- load, unload --------------------------------------------------------------------------------------------


def _load_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_container_argument(parser)
    add_component_arguments(parser)
    parser.add_argument(
        '-q', '--quiet', action='store_true', help='Print only the id and the name of the component'
    )


def _load(arguments: Namespace, output: Output) -> Outcome:
    container = find_container(arguments)

    async def perform(node: goalwire.Node) -> None:
        loaded = await load_component(node, container, arguments)
        if output.json:
            output.data({'container': container, 'id': loaded.unique_id, 'node': loaded.full_node_name})
        elif arguments.quiet:
            output.line(f'{loaded.unique_id}  {loaded.full_node_name}')
        else:
            output.line(
                f"Loaded component {loaded.unique_id} into '{container}' container node as "
                f"'{loaded.full_node_name}'"
            )

    return live(perform)


def _unload_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_container_argument(parser)
    parser.add_argument(
        'component_uid', type=count, nargs='+', help='Ids of the components, as `component list` shows them'
    )
    parser.add_argument('-q', '--quiet', action='store_true', help='Print only the ids')


def _unload(arguments: Namespace, output: Output) -> Outcome:
    from composition_interfaces.srv import UnloadNode

    container = find_container(arguments)

    async def perform(node: goalwire.Node) -> None:
        for unique_id in arguments.component_uid:
            response: Any = await call(
                node, UnloadNode, f'{container}/_container/unload_node', arguments, {'unique_id': unique_id}
            )
            if not response.success:
                raise CommandError(
                    Outcome.REFUSED,
                    f"the container '{container}' did not unload the component {unique_id}: "
                    f'{lookup.one_line(response.error_message)}',
                    f'see: ros2 component list {container}',
                )
            if output.json:
                output.data({'container': container, 'id': unique_id})
            elif arguments.quiet:
                output.line(str(unique_id))
            else:
                output.line(f"Unloaded component {unique_id} from '{container}' container node")

    return live(perform)


NOUN = Noun(
    'component',
    'Various component related sub-commands',
    (
        Verb('list', 'Output a list of running containers and components', _list, _list_arguments),
        Verb('load', 'Load a component into a container node', _load, _load_arguments),
        Verb(
            'standalone',
            'Run a component into its own standalone container node',
            component_standalone.run,
            component_standalone.arguments,
            has_json=False,
        ),
        Verb(
            'types',
            'Output a list of components registered in the ament index, and of those in Python',
            _types,
            _types_arguments,
        ),
        Verb('unload', 'Unload a component from a container node', _unload, _unload_arguments),
    ),
)
