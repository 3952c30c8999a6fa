"""ros2 param: list, get, describe, dump; set, load and delete are in change.py."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.param.change import (
    change,
    delete,
    delete_arguments,
    load,
    load_arguments,
    set_arguments,
)
from goalwire.apps.cli.commands.param.reading import parameter_arguments, parameters_of
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.nodes import (
    add_node_argument,
    add_timeout_argument,
    find_node,
    node_names,
)
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb, did_you_mean
from goalwire.errors import with_advice
from goalwire.observe.parameters import kind_name, plain_value
from goalwire.rules.parameters.messages import value_of

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.observe.parameters import NodeParameters

_LABELS: tuple[str, ...] = (
    '',
    'Boolean value is:',
    'Integer value is:',
    'Double value is:',
    'String value is:',
    'Byte values are:',
    'Boolean values are:',
    'Integer values are:',
    'Double values are:',
    'String values are:',
)


def _plain(value: Any) -> Any:
    """Return the plain value of a ParameterValue message, an array as a list; raises CommandError."""
    try:
        return value_of(value)
    except RuntimeError:
        problem = f'the node answers with the unknown parameter type {value.type}'
        raise CommandError(Outcome.FAILED, problem) from None


async def _unknown_parameter(parameters: NodeParameters, name: str, parameter: str) -> CommandError:
    near = did_you_mean(parameter, await parameters.names())
    return CommandError(
        Outcome.NOT_FOUND,
        f"the node '{name}' has no parameter '{parameter}'",
        with_advice(near, f'see: ros2 param list {name}'),
    )


# -- list ----------------------------------------------------------------------------------------------------


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_node_argument(parser, optional=True)
    add_timeout_argument(parser)
    parser.add_argument(
        '--param-prefixes', metavar='P', nargs='+', default=[], help='Only parameters that begin so'
    )
    parser.add_argument('--param-type', action='store_true', help='Show the types, too')
    parser.add_argument(
        '--filter', metavar='REGEX', help='Only parameters whose name the expression is found in'
    )


def _list(arguments: Namespace, output: Output) -> Outcome:
    try:
        wanted = re.compile(arguments.filter or '')
    except re.error as error:
        problem = f"--filter '{arguments.filter}' is not a regular expression: {error.msg}"
        raise CommandError(Outcome.BAD_VALUE, problem, 'quote it') from None
    if arguments.node_name:
        nodes = [find_node(arguments)]
    else:
        with discovered(arguments) as graph:
            serving = {name for name, _ in graph.service_names_and_types()}
            nodes = node_names(graph, include_hidden=arguments.include_hidden_nodes)
        nodes = sorted({name for name in nodes if f'{name}/list_parameters' in serving}, key=_in_ros_2)

    async def show(node: goalwire.Node) -> Outcome:
        outcome = Outcome.OK
        for name in nodes:
            try:
                await _show_names(node, name, wanted, arguments, output)
            except goalwire.CallError as error:
                if arguments.node_name:
                    raise
                tell(f"Exception while calling service of node '{name}': {error}")
                outcome = Outcome.SERVER_LOST
        return outcome

    return live(show)


def _in_ros_2(full_name: str) -> tuple[str, str]:
    """Return the sort key of a node in `ros2 param list`: its name before its namespace."""
    namespace, _, name = full_name.rpartition('/')
    return name, namespace


async def _show_names(
    node: goalwire.Node, name: str, wanted: re.Pattern[str], arguments: Namespace, output: Output
) -> None:
    parameters = parameters_of(node, name, arguments)
    names = [each for each in await parameters.names(arguments.param_prefixes) if wanted.search(each)]
    types: dict[str, str] = {}
    if names and (arguments.param_type or output.json):
        found = await parameters.descriptors(names)
        types = {each: kind_name(about.type) for each, about in found.items()}
    if output.json:
        for each in names:
            output.data({'node': name, 'name': each, 'type': types.get(each)})
        return
    if not arguments.node_name:
        output.line(f'{name}:')
    for each in names:
        output.line(f'  {each} (type: {types[each]})' if arguments.param_type else f'  {each}')


# -- get, describe, dump -------------------------------------------------------------------------------------


def _get_arguments(parser: ArgumentParser) -> None:
    parameter_arguments(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')
    parser.add_argument('--hide-type', action='store_true', help='Print only the value')


def _get(arguments: Namespace, output: Output) -> Outcome:
    name = find_node(arguments)

    async def show(node: goalwire.Node) -> None:
        wanted = arguments.parameter_name
        parameters = parameters_of(node, name, arguments)
        value = (await parameters.values([wanted])).get(wanted)
        if value is None:
            raise await _unknown_parameter(parameters, name, wanted)
        plain = _plain(value)
        if output.json:
            kind = kind_name(value.type)
            output.data({'node': name, 'name': wanted, 'type': kind, 'value': plain_value(value)})
        else:
            output.block(str(plain) if arguments.hide_type else f'{_LABELS[value.type]} {plain}')

    return live(show)


def _describe_arguments(parser: ArgumentParser) -> None:
    parameter_arguments(parser)
    parser.add_argument('parameter_names', nargs='+', help='Names of the parameters')


def _describe(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.observe.messages import as_dict

    name = find_node(arguments)

    async def show(node: goalwire.Node) -> None:
        parameters = parameters_of(node, name, arguments)
        known = set(await parameters.names())
        for each in arguments.parameter_names:
            if each not in known:
                raise await _unknown_parameter(parameters, name, each)
        for about in (await parameters.descriptors(arguments.parameter_names)).values():
            if output.json:
                output.data(as_dict(about))
            else:
                _print_descriptor(about, output)

    return live(show)


def _print_descriptor(descriptor: Any, output: Output) -> None:
    output.line(f'Parameter name: {descriptor.name}')
    output.line(f'  Type: {kind_name(descriptor.type)}')
    if descriptor.description:
        output.line(f'  Description: {descriptor.description}')
    output.line('  Constraints:')
    if descriptor.read_only:
        output.line('    Read only: true')
    for limits in [*descriptor.floating_point_range, *descriptor.integer_range][:1]:
        output.line(f'    Min value: {limits.from_value}')
        output.line(f'    Max value: {limits.to_value}')
        if limits.step:
            output.line(f'    Step: {limits.step}')
    if descriptor.additional_constraints:
        output.line(f'    Additional constraints: {descriptor.additional_constraints}')


def _dump(arguments: Namespace, output: Output) -> Outcome:
    name = find_node(arguments)

    async def show(node: goalwire.Node) -> None:
        parameters = parameters_of(node, name, arguments)
        values = await parameters.values(await parameters.names())
        tree: dict[str, Any] = {}
        for each, value in values.items():
            plain = _plain(value)
            _insert(tree, each.split('.'), plain_value(value) if output.json else plain)
        document = {name: {'ros__parameters': tree}}
        if output.json:
            output.data(document)
            return
        import yaml

        output.block(yaml.safe_dump(document, default_flow_style=False))

    return live(show)


def _insert(tree: dict[str, Any], path: list[str], value: Any) -> None:
    for at, part in enumerate(path[:-1]):
        inner = tree.setdefault(part, {})
        # The parameter `a` has a value, so `a.b` cannot go below it: the name stays whole.
        if not isinstance(inner, dict):
            tree['.'.join(path[at:])] = value
            return
        tree = inner
    tree[path[-1]] = value


NOUN = Noun(
    'param',
    'Various param related sub-commands',
    (
        Verb('delete', 'Delete parameter', delete, delete_arguments),
        Verb(
            'describe',
            'Show descriptive information about declared parameters',
            _describe,
            _describe_arguments,
        ),
        Verb(
            'dump', 'Show all of the parameters of a node in a YAML file format', _dump, parameter_arguments
        ),
        Verb('get', 'Get parameter', _get, _get_arguments),
        Verb('list', 'Output a list of available parameters', _list, _list_arguments),
        Verb('load', 'Load parameter file for a node', load, load_arguments),
        Verb('set', 'Set parameter', change, set_arguments),
    ),
)
