"""ros2 param: list, get, describe, dump; set, load and delete are in param_change.py."""

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
from goalwire.apps.cli.commands.param.reading import descriptors_of, parameter_arguments, values_of
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.nodes import (
    add_node_argument,
    add_timeout_argument,
    call,
    named_node,
    node_names,
)
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb, did_you_mean
from goalwire.errors import with_advice

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_NOT_SET = 0
_TYPES = (
    'not set',
    'boolean',
    'integer',
    'double',
    'string',
    'byte array',
    'boolean array',
    'integer array',
    'double array',
    'string array',
)
"""By the number in rcl_interfaces/msg/ParameterType."""
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


def _type_name(number: int) -> str:
    return _TYPES[number] if number < len(_TYPES) else f'unknown ({number})'


def _plain(value: Any) -> Any:
    """Return the plain value of a ParameterValue message; raises CommandError for an unknown type."""
    from goalwire.rules.parameters.messages import value_of

    if value.type >= len(_TYPES):
        raise CommandError(Outcome.FAILED, f'the node answers with the unknown parameter type {value.type}')
    return value_of(value)


async def names_of(node: goalwire.Node, name: str, arguments: Namespace) -> list[str]:
    """Return the names of a node's parameters, sorted; raises goalwire's own errors."""
    from rcl_interfaces.srv import ListParameters

    prefixes = getattr(arguments, 'param_prefixes', [])
    response = await call(node, ListParameters, f'{name}/list_parameters', arguments, {'prefixes': prefixes})
    return sorted(response.result.names)


async def _unknown_parameter(
    node: goalwire.Node, name: str, parameter: str, arguments: Namespace
) -> CommandError:
    near = did_you_mean(parameter, await names_of(node, name, arguments))
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
        problem = f"--filter '{arguments.filter}' is no regular expression: {error.msg}"
        raise CommandError(Outcome.BAD_VALUE, problem, 'quote it') from None
    if arguments.node_name:
        nodes = [named_node(arguments)]
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
    """Sort nodes as `ros2 param list` does: by their own names first."""
    namespace, _, name = full_name.rpartition('/')
    return name, namespace


async def _show_names(
    node: goalwire.Node, name: str, wanted: re.Pattern[str], arguments: Namespace, output: Output
) -> None:
    names = [each for each in await names_of(node, name, arguments) if wanted.search(each)]
    types: dict[str, str] = {}
    if names and (arguments.param_type or output.json):
        found = await descriptors_of(node, name, names, arguments)
        types = {each.name: _type_name(each.type) for each in found}
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
    parser.add_argument('--hide-type', action='store_true', help='Print the value alone')


def _get(arguments: Namespace, output: Output) -> Outcome:
    name = named_node(arguments)

    async def show(node: goalwire.Node) -> None:
        values = await values_of(node, name, [arguments.parameter_name], arguments)
        if not values or values[0].type == _NOT_SET:
            raise await _unknown_parameter(node, name, arguments.parameter_name, arguments)
        value = values[0]
        plain = _plain(value)  # an array as a list, as ROS 2 prints it
        if output.json:
            kind = _TYPES[value.type]
            output.data({'node': name, 'name': arguments.parameter_name, 'type': kind, 'value': _json(value)})
        else:
            output.block(str(plain) if arguments.hide_type else f'{_LABELS[value.type]} {plain}')

    return live(show)


def _json(value: Any) -> Any:
    plain = _plain(value)
    return (
        [each[0] if isinstance(each, bytes) else each for each in plain] if isinstance(plain, list) else plain
    )


def _describe_arguments(parser: ArgumentParser) -> None:
    parameter_arguments(parser)
    parser.add_argument('parameter_names', nargs='+', help='Names of the parameters')


def _describe(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.apps.cli.framework.messages import as_dict

    name = named_node(arguments)

    async def show(node: goalwire.Node) -> None:
        known = set(await names_of(node, name, arguments))
        for each in arguments.parameter_names:
            if each not in known:
                raise await _unknown_parameter(node, name, each, arguments)
        for each in await descriptors_of(node, name, arguments.parameter_names, arguments):
            if output.json:
                output.data(as_dict(each))
            else:
                _print_descriptor(each, output)

    return live(show)


def _print_descriptor(descriptor: Any, output: Output) -> None:
    output.line(f'Parameter name: {descriptor.name}')
    output.line(f'  Type: {_type_name(descriptor.type)}')
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
    name = named_node(arguments)

    async def show(node: goalwire.Node) -> None:
        names = await names_of(node, name, arguments)
        shown = _json if output.json else _plain
        tree: dict[str, Any] = {}
        for each, value in await _set_values(node, name, names, arguments):
            _insert(tree, each.split('.'), shown(value))
        document = {name: {'ros__parameters': tree}}
        if output.json:
            output.data(document)
            return
        import yaml

        output.block(yaml.safe_dump(document, default_flow_style=False))

    return live(show)


async def _set_values(
    node: goalwire.Node, name: str, names: list[str], arguments: Namespace
) -> list[tuple[str, Any]]:
    """Return names and values of those parameters that have one."""
    values = await values_of(node, name, names, arguments) if names else []
    if len(values) != len(names):  # a node says nothing at all if one of them has a type and no value yet
        alone = [await values_of(node, name, [each], arguments) for each in names]
        found = [(each, value[0]) for each, value in zip(names, alone, strict=True) if value]
    else:
        found = list(zip(names, values, strict=True))
    return [(each, value) for each, value in found if value.type != _NOT_SET]


def _insert(tree: dict[str, Any], path: list[str], value: Any) -> None:
    for at, part in enumerate(path[:-1]):
        inner = tree.setdefault(part, {})
        if not isinstance(inner, dict):  # a.b beside a: what does not fit below keeps its whole name
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
