"""Parameter files: YAML of node names, each with `ros__parameters`, by the rules of rcl_yaml_param_parser.

    /robot/arm:               # a node; `/*` stands for one part of a name, `/**` for any number of them
      ros__parameters:
        speed: 0.5
        grip: {force: 3.0}    # the parameter grip.force
    robot:                    # a namespace
      head:
        ros__parameters: {tilt: 0.1}

The syntax differs from YAML: scalars are read by the rules of `-p` (value_syntax.py), the last of two equal
keys wins, and aliases are refused. entities/parameters/files.py reads the file from the disk.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NoReturn, TypeAlias

from goalwire.rules.names.lexer import RuleSyntaxError
from goalwire.rules.names.validation import InvalidName, validate_namespace, validate_node_name
from goalwire.rules.parameters.value_syntax import line_of, plain_value, sequence_value

if TYPE_CHECKING:
    import yaml

    from goalwire.rules.parameters.parameter import ParameterValue

KEY = 'ros__parameters'

NodeValues: TypeAlias = 'dict[str, dict[str, ParameterValue]]'
"""For each node name as written in the file (`a/b` means `/a/b`): values by dotted parameter names."""


def parse_parameter_file(data: bytes) -> NodeValues:
    """Read the content of a parameter file; raises RuleSyntaxError with ROS 2's text and the line."""
    import yaml

    nodes: NodeValues = {}
    try:
        events = iter(yaml.parse(data, Loader=getattr(yaml, 'CSafeLoader', yaml.SafeLoader)))
        for event in events:
            if isinstance(event, yaml.MappingStartEvent):
                _read_nodes(events, '', event, nodes)
            elif isinstance(event, yaml.SequenceStartEvent):
                _refuse('Sequences cannot be key', event)
            elif isinstance(event, yaml.ScalarEvent):
                _refuse(f'There must be names of nodes, each with {KEY}, instead of a value', event)
    except yaml.YAMLError as error:
        raise RuleSyntaxError(_not_yaml(error, data)) from error
    except RecursionError:
        raise RuleSyntaxError('Mappings are nested too deeply') from None
    return nodes


def matches(pattern: str, full_node_name: str) -> bool:
    """Tell whether a node name in a file, perhaps with wildcards, matches a node's fully qualified name."""
    absolute = _absolute(pattern)
    if '*' not in absolute:
        return absolute == full_node_name
    return _parts_match(absolute.split('/')[1:], full_node_name.split('/')[1:])


def _absolute(name: str) -> str:
    return name if name.startswith('/') else f'/{name}'


def _parts_match(pattern: list[str], name: list[str]) -> bool:
    """Match a pattern with a name, part by part.

    If the rest does not match, the last `**` is extended by one part of the name, and matching resumes behind
    it. An earlier `**` never has to be extended, so the time is bounded by the product of the lengths.
    """
    at = in_name = 0
    last, taken = -1, 0
    while in_name < len(name):
        if at < len(pattern) and pattern[at] == '**':
            last, taken = at, in_name
            at += 1
        elif at < len(pattern) and pattern[at] in {'*', name[in_name]}:
            at, in_name = at + 1, in_name + 1
        elif last >= 0:
            taken += 1
            at, in_name = last + 1, taken
        else:
            return False
    return all(part == '**' for part in pattern[at:])


def _read_nodes(events: Iterator[yaml.Event], namespace: str, where: yaml.Event, nodes: NodeValues) -> None:
    """Read a mapping of node names and namespaces up to its end.

    The mapping belongs to `namespace`, '' at the top.
    """
    import yaml

    seen_parameters = False
    for key in events:
        if isinstance(key, yaml.MappingEndEvent):
            return
        name = _key(key)
        value = next(events)
        if name == KEY and namespace:
            if seen_parameters:
                _refuse(f"'{namespace}' has {KEY} twice: the second", key)
            values = nodes.setdefault(_node_name(namespace, where), {})
            _read_parameters(events, value, values)
            seen_parameters = True
        elif name == KEY:
            _refuse(f'There are no node names before {KEY}', key)
        elif isinstance(value, yaml.MappingStartEvent) and not seen_parameters:
            inner = f'{namespace.removesuffix("/")}/{name}' if namespace else name
            _read_nodes(events, inner, key, nodes)
        elif isinstance(value, yaml.MappingStartEvent):
            _refuse(f"'{name}' cannot follow {KEY} of '{namespace}'", key)
        elif isinstance(value, yaml.SequenceStartEvent):
            _refuse('Sequences can only be values and not keys in params. Error', value)
        else:
            _refuse(f'Cannot have a value before {KEY}', value, _MISSING_KEY)


def _read_parameters(
    events: Iterator[yaml.Event], value: yaml.Event, values: dict[str, ParameterValue]
) -> None:
    """Read the mapping after `ros__parameters:`."""
    import yaml

    if isinstance(value, yaml.MappingStartEvent):
        _read_values(events, '', values)
    elif not (isinstance(value, yaml.SequenceStartEvent) and isinstance(next(events), yaml.SequenceEndEvent)):
        _refuse(f'Cannot have a value before {KEY}', value, _MISSING_KEY)


def _read_values(events: Iterator[yaml.Event], prefix: str, values: dict[str, ParameterValue]) -> None:
    """Read a mapping of parameters up to its end."""
    import yaml

    for key in events:
        if isinstance(key, yaml.MappingEndEvent):
            return
        name = f'{prefix}{_key(key)}'
        value = next(events)
        if isinstance(value, yaml.MappingStartEvent):
            _read_values(events, f'{name}.', values)
        elif isinstance(value, yaml.SequenceStartEvent):
            values[name] = sequence_value(events)
        elif isinstance(value, yaml.ScalarEvent):
            values[name] = plain_value(value)
        else:
            _refuse('Will not support aliasing', value)


def _key(event: yaml.Event) -> str:
    import yaml

    if isinstance(event, yaml.ScalarEvent):
        return event.value or _refuse('No key', event)
    if isinstance(event, yaml.AliasEvent):
        return _refuse('Will not support aliasing', event)
    kind = 'Sequences' if isinstance(event, yaml.SequenceStartEvent) else 'Mappings'
    return _refuse(f'{kind} cannot be key', event)


def _node_name(name: str, where: yaml.Event) -> str:
    """Return a node's name after checking it: each part must be valid, or a wildcard."""
    if '//' in name:
        _refuse(f"'{name}' contains repeated forward slash", where)
    namespace, _, node = _absolute(name).rpartition('/')
    plain = [part for part in namespace.split('/') if part not in {'*', '**'}]
    try:
        validate_namespace('/'.join(plain) or '/')
        if node not in {'*', '**'}:
            validate_node_name(node)
    except InvalidName as error:
        _refuse(f"'{name}': {error.reason}", where)
    return name


_MISSING_KEY = f"; write the line '{KEY}:' between the node's name and its parameters"


def _refuse(what: str, where: yaml.Event, hint: str = '') -> NoReturn:
    raise RuleSyntaxError(f'{what} at line {line_of(where)}{hint}')


def _not_yaml(error: yaml.YAMLError, data: bytes) -> str:
    mark = getattr(error, 'problem_mark', None)
    problem = getattr(error, 'problem', None) or getattr(error, 'reason', None) or error
    line = mark.line if mark else 0
    text = data.split(b'\n', line + 1)[line : line + 1]
    indent = text[0][: len(text[0]) - len(text[0].lstrip())] if text else b''
    hint = ' (the line begins with a tab: YAML is indented with spaces)' if b'\t' in indent else ''
    return f'Error parsing a event near line {line + 1 if mark else 0}: {problem}{hint}'
