"""Parameter files: YAML of node names (or `/**`), each with `ros__parameters` (rcl_yaml_param_parser)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from goalwire.entities.exceptions import RCLError

if TYPE_CHECKING:
    from goalwire.protocol.parameters import ParameterValue

_KEY = 'ros__parameters'


def parameters_from_file(path: str, full_node_name: str) -> dict[str, ParameterValue]:
    """Return what a file gives to one node, by dotted names; raises RCLError that names file and key."""
    import yaml

    try:
        content = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except OSError as error:
        raise RCLError(
            f"failed to initialize rcl: Couldn't parse params file: '--params-file {path}'. "
            f'Error: Error opening YAML file ({error.strerror})'
        ) from None
    except yaml.YAMLError as error:
        raise RCLError(f"Couldn't parse params file '{path}': {error}") from None
    values: dict[str, ParameterValue] = {}
    for node, parameters in _nodes(content, '', path):
        if node in {'/**', full_node_name}:
            values.update(_flat(parameters, ''))
    return values


def _nodes(tree: Any, prefix: str, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    if not isinstance(tree, dict):
        raise RCLError(
            f"Couldn't parse params file '{path}': '{prefix or '/'}' must hold node names, not {tree!r}"
        )
    for key, branch in tree.items():
        name = f'{prefix}/{str(key).strip("/")}'
        if isinstance(branch, dict) and _KEY in branch:
            if not isinstance(branch[_KEY], dict):
                raise RCLError(f"Couldn't parse params file '{path}': {_KEY} of '{name}' must be a mapping")
            yield name, branch[_KEY]
        else:
            yield from _nodes(branch, name, path)


def _flat(parameters: dict[str, Any], prefix: str) -> Iterator[tuple[str, ParameterValue]]:
    for key, value in parameters.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value
