"""Converts evaluated parameters to the list of parameters in a request to a component container."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from goalwire.errors import BadLaunchValueError, LaunchError
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular, show
from goalwire.launching.model import LaunchContext
from goalwire.launching.ros.parameters import evaluate_dictionary
from goalwire.rules.parameters.file_syntax import KEY, matches
from goalwire.rules.parameters.parameter import Parameter, Type


def to_parameters_list(
    context: LaunchContext, node_name: str, namespace: str | None, evaluated_parameters: Iterable[Any]
) -> list[Parameter]:
    """Return a node's parameters from mappings and paths to parameter files.

    Raises LaunchError for a file that cannot be read, BadLaunchValueError for an invalid value.
    """
    full_name = f'/{(namespace or "").strip("/")}/{node_name.lstrip("/")}'.replace('//', '/')
    found: list[Parameter] = []
    for item in evaluated_parameters:
        values = values_for_node(context, item, full_name) if isinstance(item, Path) else item
        if not isinstance(values, Mapping):
            raise BadLaunchValueError(f'expected a mapping of parameters or a path, got {values!r:.100}')
        found += [_parameter(name, value) for name, value in values.items()]
    return found


def values_for_node(context: LaunchContext, path: Path, full_name: str) -> dict[str, Any]:
    """Return a file's parameters for one node. The node's exact name takes precedence over `/**`."""
    try:
        content = yaml.safe_load(read_regular(str(path), LARGEST_PARAMETER_FILE))
    except OSError as error:
        raise LaunchError(f'cannot read the parameter file {show(str(path))}: {error.strerror}') from error
    except (yaml.YAMLError, UnicodeError) as error:
        reason = ' '.join(str(error).split())
        raise LaunchError(f'the parameter file {show(str(path))} is not valid YAML: {reason}') from error
    if not isinstance(content, Mapping):
        raise LaunchError(f'the parameter file {show(str(path))} holds no names of nodes')
    nodes = dict(_by_node(content, ''))
    if not nodes:
        return evaluate_dictionary(context, content)
    values: dict[str, Any] = {}
    for pattern in sorted(nodes, key=lambda name: '*' not in name):
        if matches(pattern, full_name):
            values.update(evaluate_dictionary(context, nodes[pattern]))
    return values


def _by_node(content: Mapping[Any, Any], prefix: str) -> Iterator[tuple[str, Mapping[Any, Any]]]:
    """Yield the parameters of each node in a file, with the node's full name."""
    for key, value in content.items():
        if key == KEY and isinstance(value, Mapping):
            yield prefix, value
        elif isinstance(value, Mapping):
            yield from _by_node(value, f'{prefix}/{str(key).strip("/")}'.replace('//', '/'))


def _parameter(name: str, value: Any) -> Parameter:
    if isinstance(value, bytes):
        return Parameter(name, Type.BYTE_ARRAY, [bytes([item]) for item in value])
    if isinstance(value, tuple):
        value = list(value)
    try:
        return Parameter(name, Type.from_parameter_value(value), value)
    except (TypeError, ValueError) as error:
        raise BadLaunchValueError(f"parameter '{name}': {error}") from error
