"""Reads values by YAML's own rules, like `ros2 param` (rclpy.parameter). `-p` reads values by other rules."""

from __future__ import annotations

import reprlib
from datetime import date
from typing import TYPE_CHECKING, TypeAlias, cast

from goalwire.errors import FileShapeError
from goalwire.idl.field_values import plain_values
from goalwire.rules.parameters.file_syntax import KEY, matches
from goalwire.rules.parameters.parameter import SCALARS, ParameterValue, Type, is_kind

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    Below: TypeAlias = dict[object, object]

Typed: TypeAlias = tuple[Type, ParameterValue]


_MOST_VALUES = 1_000_000


def read_typed_text(text: str) -> Typed:
    """Return the value of a YAML text with its type. A text that has no other type is a string."""
    import yaml

    try:
        typed = _type_value(yaml.safe_load(text))
    except Exception:  # PyYAML raises errors of many types: for invalid dates, too many digits, deep nesting
        typed = None
    return typed or (Type.STRING, text)


def read_typed_value(name: str, value: object) -> Typed:
    """Return a value from YAML with its type; raises FileShapeError for a value that no parameter holds."""
    if value is None:
        return Type.STRING, 'null'  # as in rclpy, null in a file is the text 'null'
    if isinstance(value, date):
        return Type.STRING, str(value)
    try:
        typed = _type_value(value)
    except OverflowError:
        typed = None
    if typed is None:
        raise FileShapeError(
            f"parameter '{name}': {reprlib.repr(value)} is not a value, nor a sequence of values of one type"
        )
    return typed


def _type_value(value: object) -> Typed | None:
    if isinstance(value, list):
        for kind, _, several in SCALARS:  # the first type that fits wins, so `[]` is a list of booleans
            if all(is_kind(element, kind) for element in value) and several.check(value):
                return several, value
        return None
    for kind, one, _ in SCALARS:
        if is_kind(value, kind):
            fits = one.check(value)
            return (one, cast('ParameterValue', value)) if fits else (Type.DOUBLE, float(cast('int', value)))
    return None


def flat_values(content: object, nodes: list[str] | None, *, use_wildcard: bool) -> dict[str, object]:
    """Return the values in a file's content for some nodes (None: for all), by dotted parameter names.

    In the file, a node stands under its full name, or below its namespace. With `use_wildcard` the values of
    `/**` apply first, then those of names such as `/*/arm` that match a node. Without `use_wildcard`, names
    that have a `*` are left out, as in rclpy since 7.1.11. Raises FileShapeError.
    """
    if not isinstance(content, dict):
        raise FileShapeError(
            'a parameter file holds names of nodes, each with ros__parameters; '
            f'not {reprlib.repr(plain_values(content))}'
        )
    branches: dict[str, list[object]] = {}
    for name, branch in _branches(content):
        branches.setdefault(name, []).append(branch)
    chosen = [name for name in branches if use_wildcard and name == '/**']
    for node in nodes or ():
        chosen += _names_of(node, branches, use_wildcard=use_wildcard)
    if not nodes:
        chosen += [name for name in branches if name != '/**' and (use_wildcard or '*' not in name)]
    if not chosen:
        raise FileShapeError('Param file does not contain selected parameters')
    values: dict[str, object] = {}
    for name in chosen:
        for branch in branches[name]:
            values.update(_flat(_parameters(name, branch), ''))
    return values


def _branches(content: dict[object, object]) -> Iterator[tuple[str, object]]:
    """Yield each node's name in a file, with its namespace (`/left/arm`), and what is below the name."""
    for name, branch in content.items():
        if _is_namespace(branch):
            namespace = str(name).rstrip('/')
            yield from ((f'{namespace}/{node}', below) for node, below in cast('Below', branch).items())
        else:
            yield str(name), branch


def _is_namespace(branch: object) -> bool:
    """Tell whether a mapping is a namespace: its keys are names of nodes, each with parameters."""
    if not isinstance(branch, dict) or KEY in branch or not branch:
        return False
    return all(isinstance(below, dict) and KEY in below for below in branch.values())


def _names_of(node: str, branches: Collection[str], *, use_wildcard: bool) -> list[str]:
    """Return the names in a file that match a node; raises FileShapeError if none does."""
    absolute = node if node.startswith('/') else f'/{node}'
    patterns = [name for name in branches if use_wildcard and '*' in name and name != '/**']
    names = [name for name in patterns if matches(name, absolute)]
    names += [name for name in branches if name == node or ('*' not in name and matches(name, absolute))]
    if not names:
        # rclpy has one text for names with a namespace, and another for names without.
        missing = 'selected parameters: none' if '/' in absolute[1:] else 'parameters'
        raise FileShapeError(
            f'Param file does not contain {missing} for {node},only for nodes: {reprlib.repr(list(branches))}'
        )
    return names


def _parameters(node: str, branch: object) -> dict[object, object]:
    found = branch.get(KEY) if isinstance(branch, dict) else None
    if not isinstance(found, dict):
        raise FileShapeError(f'YAML file is not a valid ROS parameter file for node {node}')
    return found


def _flat(parameters: dict[object, object], prefix: str) -> dict[str, object]:
    values: dict[str, object] = {}
    for key, value in parameters.items():
        if isinstance(value, dict):
            values.update(_flat(value, f'{prefix}{key}.'))
        else:
            values[f'{prefix}{key}'] = value
        if len(values) > _MOST_VALUES:  # aliases in YAML could multiply the data without bound
            raise FileShapeError(f'more than {_MOST_VALUES:,} parameters')
    return values
