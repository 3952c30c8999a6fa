"""ros2 param: list, get, set, describe, dump, load, delete."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.cli import lookup
from goalwire.cli.discovery import add_graph_arguments, discovered
from goalwire.cli.live import live
from goalwire.cli.nodes import add_node_argument, add_timeout_argument, call, named_node, node_names
from goalwire.cli.outcome import CommandError, Outcome
from goalwire.cli.output import tell
from goalwire.cli.verbs import Noun, Verb, did_you_mean

if TYPE_CHECKING:
    from goalwire.cli.output import Output

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
_FIELDS = (
    '',
    'bool',
    'integer',
    'double',
    'string',
    'byte_array',
    'bool_array',
    'integer_array',
    'double_array',
    'string_array',
)
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


def _arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_node_argument(parser)
    add_timeout_argument(parser)


def _plain(value: Any) -> Any:
    """Return the plain value of a ParameterValue message."""
    from goalwire.rules.parameters.messages import value_of

    return value_of(value)


async def names_of(node: goalwire.Node, name: str, arguments: Namespace) -> list[str]:
    """Return the names of a node's parameters, sorted; raises goalwire's own errors."""
    from rcl_interfaces.srv import ListParameters

    prefixes = getattr(arguments, 'param_prefixes', [])
    response = await call(node, ListParameters, f'{name}/list_parameters', arguments, {'prefixes': prefixes})
    return sorted(response.result.names)


async def _values(node: goalwire.Node, name: str, names: list[str], arguments: Namespace) -> list[Any]:
    from rcl_interfaces.srv import GetParameters

    response = await call(node, GetParameters, f'{name}/get_parameters', arguments, {'names': names})
    found: list[Any] = list(response.values)
    return found


async def _unknown_parameter(
    node: goalwire.Node, name: str, parameter: str, arguments: Namespace
) -> CommandError:
    near = did_you_mean(parameter, await names_of(node, name, arguments))
    return CommandError(
        Outcome.NOT_FOUND,
        f"the node '{name}' has no parameter '{parameter}'",
        f'{near} see: ros2 param list {name}'.lstrip(),
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
        raise CommandError(Outcome.BAD_VALUE, f"--filter '{arguments.filter}': {error}", 'quote it') from None
    if arguments.node_name:
        nodes = [named_node(arguments)]
    else:
        with discovered(arguments) as graph:
            serving = {name for name, _ in graph.service_names_and_types()}
            nodes = node_names(graph, include_hidden=arguments.include_hidden_nodes)
        nodes = sorted({name for name in nodes if f'{name}/list_parameters' in serving})

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


async def _show_names(
    node: goalwire.Node, name: str, wanted: re.Pattern[str], arguments: Namespace, output: Output
) -> None:
    names = [each for each in await names_of(node, name, arguments) if wanted.search(each)]
    types: dict[str, str] = {}
    if names and (arguments.param_type or output.json):
        found = await _descriptors(node, name, names, arguments)
        types = {each.name: _TYPES[each.type] for each in found}
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
    _arguments(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')
    parser.add_argument('--hide-type', action='store_true', help='Print the value alone')


def _get(arguments: Namespace, output: Output) -> Outcome:
    name = named_node(arguments)

    async def show(node: goalwire.Node) -> None:
        values = await _values(node, name, [arguments.parameter_name], arguments)
        if not values or values[0].type == _NOT_SET:
            raise await _unknown_parameter(node, name, arguments.parameter_name, arguments)
        value = values[0]
        shown = getattr(value, f'{_FIELDS[value.type]}_value')
        if output.json:
            kind = _TYPES[value.type]
            output.data({'node': name, 'name': arguments.parameter_name, 'type': kind, 'value': _json(value)})
        else:
            output.block(f'{shown}' if arguments.hide_type else f'{_LABELS[value.type]} {shown}')

    return live(show)


def _json(value: Any) -> Any:
    plain = _plain(value)
    return (
        [each[0] if isinstance(each, bytes) else each for each in plain] if isinstance(plain, list) else plain
    )


async def _descriptors(node: goalwire.Node, name: str, names: list[str], arguments: Namespace) -> list[Any]:
    from rcl_interfaces.srv import DescribeParameters

    response = await call(
        node, DescribeParameters, f'{name}/describe_parameters', arguments, {'names': names}
    )
    found: list[Any] = list(response.descriptors)
    return found


def _describe_arguments(parser: ArgumentParser) -> None:
    _arguments(parser)
    parser.add_argument('parameter_names', nargs='+', help='Names of the parameters')


def _describe(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.messages import as_dict

    name = named_node(arguments)

    async def show(node: goalwire.Node) -> None:
        known = set(await names_of(node, name, arguments))
        for each in arguments.parameter_names:
            if each not in known:
                raise await _unknown_parameter(node, name, each, arguments)
        for each in await _descriptors(node, name, arguments.parameter_names, arguments):
            if output.json:
                output.data(as_dict(each))
            else:
                _print_descriptor(each, output)

    return live(show)


def _print_descriptor(descriptor: Any, output: Output) -> None:
    output.line(f'Parameter name: {descriptor.name}')
    output.line(f'  Type: {_TYPES[descriptor.type]}')
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
        values = [_json(value) for value in await _values(node, name, names, arguments)] if names else []
        tree: dict[str, Any] = {}
        for each, value in zip(names, values, strict=False):
            _insert(tree, each.split('.'), value)
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
        if not isinstance(inner, dict):  # a.b beside a: what does not fit below keeps its whole name
            tree['.'.join(path[at:])] = value
            return
        tree = inner
    tree[path[-1]] = value


# -- set, load, delete ---------------------------------------------------------------------------------------


def _set_arguments(parser: ArgumentParser) -> None:
    _arguments(parser)
    parser.add_argument(
        'pairs', nargs='+', metavar='NAME VALUE', help='Names and values, in YAML; name=value, too'
    )


def _pairs(words: list[str]) -> list[tuple[str, str]]:
    if all('=' in word for word in words):
        return [(name, value) for name, _, value in (word.partition('=') for word in words)]
    if len(words) % 2:
        raise CommandError(
            Outcome.USAGE,
            f"the parameter '{words[-1]}' is given no value",
            'write: NAME VALUE [NAME VALUE …]',
        )
    return list(zip(words[::2], words[1::2], strict=True))


def _set(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.entities.parameters.files import parameter_value_from_text

    pairs = [(name, parameter_value_from_text(value)) for name, value in _pairs(arguments.pairs)]
    prefix = 'Set parameter successful', 'Setting parameter failed'
    return _change(arguments, output, pairs, lambda name: _titled(prefix, name if len(pairs) > 1 else ''))


def _titled(texts: tuple[str, str], name: str) -> tuple[str, str]:
    return (f'{name}: {texts[0]}', f'{name}: {texts[1]}') if name else texts


def _delete_arguments(parser: ArgumentParser) -> None:
    _arguments(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')


def _delete(arguments: Namespace, output: Output) -> Outcome:
    from rcl_interfaces.msg import ParameterValue

    texts = 'Deleted parameter successfully', 'Deleting parameter failed'
    return _change(arguments, output, [(arguments.parameter_name, ParameterValue())], lambda _name: texts)


def _load_arguments(parser: ArgumentParser) -> None:
    _arguments(parser)
    parser.add_argument('parameter_file', help='A file as param dump writes it')
    parser.add_argument(
        '--no-use-wildcard', action='store_true', help="Leave out what the file has for '/**'"
    )


def _load(arguments: Namespace, output: Output) -> Outcome:
    import yaml

    from goalwire.entities.parameters.files import parameters_from_yaml_file

    name, file = named_node(arguments), arguments.parameter_file
    try:
        found = parameters_from_yaml_file(file, [name], '', use_wildcard=not arguments.no_use_wildcard)
    except (OSError, yaml.YAMLError, RuntimeError) as error:
        code = Outcome.NOT_FOUND if isinstance(error, OSError) else Outcome.BAD_VALUE
        raise CommandError(
            code, f"cannot load '{file}': {' '.join(str(error).split())}", 'name another file'
        ) from None
    pairs = [(each.name, each.value) for each in found.values()]
    if not pairs:
        raise CommandError(
            Outcome.NOT_FOUND, f"'{file}' has no parameters for '{name}'", f'see: ros2 param dump {name}'
        )
    return _change(
        arguments,
        output,
        pairs,
        lambda each: (f'Set parameter {each} successful', f'Set parameter {each} failed'),
    )


def _change(arguments: Namespace, output: Output, pairs: list[tuple[str, Any]], texts: Any) -> Outcome:
    """Set parameters, one after the other as ROS 2 does, and print what became of each."""
    from rcl_interfaces.msg import Parameter
    from rcl_interfaces.srv import SetParameters

    name = named_node(arguments)
    parameters = [Parameter(name=each, value=value) for each, value in pairs]

    async def change(node: goalwire.Node) -> Outcome:
        response = await call(
            node, SetParameters, f'{name}/set_parameters', arguments, {'parameters': parameters}
        )
        outcome = Outcome.OK
        for (each, _), result in zip(pairs, response.results, strict=False):
            if output.json:
                output.data(
                    {'node': name, 'name': each, 'successful': result.successful, 'reason': result.reason}
                )
            done, failed = texts(each)
            text = (done if result.successful else failed) + (f': {result.reason}' if result.reason else '')
            if not result.successful:
                tell(lookup.one_line(text))
                outcome = Outcome.REFUSED
            elif not output.json:
                output.line(text)
        return outcome

    return live(change)


NOUN = Noun(
    'param',
    'Various param related sub-commands',
    (
        Verb('delete', 'Delete parameter', _delete, _delete_arguments),
        Verb(
            'describe',
            'Show descriptive information about declared parameters',
            _describe,
            _describe_arguments,
        ),
        Verb('dump', 'Show all of the parameters of a node in a YAML file format', _dump, _arguments),
        Verb('get', 'Get parameter', _get, _get_arguments),
        Verb('list', 'Output a list of available parameters', _list, _list_arguments),
        Verb('load', 'Load parameter file for a node', _load, _load_arguments),
        Verb('set', 'Set parameter', _set, _set_arguments),
    ),
)
