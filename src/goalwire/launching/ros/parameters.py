"""Parameters as launch files write them, and what a node gets of them.

Values are those of Python, substitutions, lists and nested mappings. What a substitution gives is read by
YAML's rules, as in launch_ros; a string that stands in the file itself stays a string.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from shutil import rmtree
from typing import Any, TypeAlias

import yaml

from goalwire.errors import LaunchError, SubstitutionFailure
from goalwire.files import shown
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.notation import parse_substitution
from goalwire.launching.values import (
    is_substitution,
    normalize_to_list_of_substitutions,
    normalize_typed_substitution,
    perform_substitutions,
    perform_text,
    perform_typed_substitution,
    truth,
)

SomeParameters: TypeAlias = Sequence[Any]
_SCALARS = (bool, int, float, str)


class ParameterValue:
    """A value, with a type for what a substitution gives."""

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self._value = normalize_typed_substitution(value, value_type)
        self._value_type = value_type

    @property
    def value(self) -> Any:
        return self._value

    @property
    def value_type(self) -> Any:
        return self._value_type

    def evaluate(self, context: LaunchContext) -> Any:
        """The value. Raises LaunchError where it is not of the type."""
        if self._value_type is None and is_substitution(self._value):
            return by_yaml(perform_substitutions(context, self._value))
        try:
            return perform_typed_substitution(context, self._value, self._value_type)
        except ValueError as error:
            raise LaunchError(f'a parameter value: {error}') from error


class Parameter:
    """A parameter by name, to be given to a node on its own."""

    def __init__(self, name: SomeSubstitutions, value: Any, *, value_type: Any = None) -> None:
        self._name = normalize_to_list_of_substitutions(name)
        self._value = ParameterValue(value, value_type=value_type)

    @property
    def name(self) -> list[Substitution]:
        return self._name

    @property
    def value(self) -> Any:
        return self._value.value

    @property
    def value_type(self) -> Any:
        return self._value.value_type

    def evaluate(self, context: LaunchContext) -> tuple[str, Any]:
        return perform_substitutions(context, self._name), self._value.evaluate(context)


class ParameterFile:
    """A parameter file; with `allow_substs` its $(…) are found out first."""

    def __init__(
        self, param_file: SomeSubstitutions, *, allow_substs: bool | SomeSubstitutions = False
    ) -> None:
        self._file = normalize_to_list_of_substitutions(param_file)
        self._allow_substs = allow_substs

    @property
    def param_file(self) -> list[Substitution]:
        return self._file

    @property
    def allow_substs(self) -> bool | SomeSubstitutions:
        return self._allow_substs

    def evaluate(self, context: LaunchContext) -> Path:
        """The path of the file that the node is to read. Raises LaunchError where it cannot be read."""
        path = Path(perform_substitutions(context, self._file))
        allowed = (
            self._allow_substs if isinstance(self._allow_substs, bool) else truth(context, self._allow_substs)
        )
        if not allowed:
            return path
        try:
            plain = yaml.safe_dump(yaml.safe_load(path.read_text(encoding='utf-8')))
            text = perform_substitutions(context, parse_substitution(plain))
            yaml.safe_load(text)
        except (yaml.YAMLError, UnicodeError) as error:
            raise SubstitutionFailure(
                f'the parameter file {shown(str(path))} is no valid YAML: {" ".join(str(error).split())}'
            ) from error
        return write_temporary(context, text)

    def cleanup(self) -> None:
        """Nothing: written files go with the launch."""


def write_temporary(context: LaunchContext, text: str) -> Path:
    """Write a parameter file that is removed when the launch has ended."""
    globals_ = context.get_globals()
    folder = globals_.get('launch_params_folder')
    if folder is None:
        folder = tempfile.mkdtemp(prefix='launch_params_')
        context.extend_globals({'launch_params_folder': folder})

        def remove() -> None:
            context.remove_globals(['launch_params_folder'])
            rmtree(folder, ignore_errors=True)

        context.cleanups.append(remove)
    descriptor, path = tempfile.mkstemp(prefix='launch_params_', suffix='.yaml', dir=folder)
    with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
        file.write(text)
    return Path(path)


def evaluate_dictionary(
    context: LaunchContext, parameters: Mapping[Any, Any], prefix: str = ''
) -> dict[str, Any]:
    """The parameters of a mapping by their full names, `arm.reach` for nested ones."""
    found: dict[str, Any] = {}
    for key, value in parameters.items():
        name = prefix + perform_text(context, key)
        if isinstance(value, Mapping):
            found |= evaluate_dictionary(context, value, f'{name}.')
        else:
            try:
                found[name] = evaluate_value(context, value)
            except (TypeError, ValueError) as error:
                raise LaunchError(f"parameter '{name}': {error}") from error
    return found


def evaluate_value(context: LaunchContext, value: Any) -> Any:
    """What one value is worth. Raises TypeError for what no parameter can be."""
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if isinstance(value, Substitution) or is_substitution(value):
        return by_yaml(perform_text(context, value))
    if isinstance(value, bytes | bool | int | float | str):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Iterable):
        return _uniform([_item(context, item) for item in value])
    if hasattr(value, 'tolist'):  # numpy's
        return evaluate_value(context, value.tolist())
    raise TypeError(f'{value!r:.100} is neither a number, a boolean, a string, bytes nor a list of them')


def _item(context: LaunchContext, item: Any) -> Any:
    if isinstance(item, Sequence) and not isinstance(item, str | bytes):
        return by_yaml(perform_text(context, item))
    return evaluate_value(context, item)


def by_yaml(text: str) -> Any:
    """What a text is by YAML's rules; itself where that is no parameter's value."""
    try:
        found = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    if isinstance(found, _SCALARS):
        return found
    if isinstance(found, list):
        return _uniform(found)
    return text


def _uniform(items: list[Any]) -> list[Any]:
    kinds = {type(item) for item in items}
    if not items or (len(kinds) == 1 and kinds <= set(_SCALARS)):
        return items
    if kinds <= {int, float}:
        return [float(item) for item in items]
    raise TypeError(f'the items of {items!r:.100} are of different types')


def as_rule(name: str, value: Any) -> str:
    """`name:=value` for the command line."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
    return f'{name}:={text.removesuffix("...").strip()}'


def as_file(node: str, parameters: Mapping[str, Any]) -> str:
    """The text of a parameter file for one node, or for '/**'."""
    return yaml.safe_dump({node: {'ros__parameters': dict(parameters)}}, default_flow_style=False)


def parse_parameters(entities: Sequence[Entity], parser: Parser) -> list[Any]:
    """The <param> tags of a node."""
    found: list[Any] = []
    for entity in entities:
        source = entity.get_attr('from', optional=True)
        allow = entity.get_attr('allow_substs', data_type=bool, optional=True)
        if source is not None:
            if entity.get_attr('name', optional=True) is not None:
                raise LaunchError("<param> takes either 'name' or 'from'")
            allowed = parser.parse_if_substitutions(allow) if allow is not None else False
            found.append(ParameterFile(parser.parse_substitution(source), allow_substs=allowed))
            entity.assert_entity_completely_parsed()
        else:
            if allow is not None:
                raise LaunchError("<param>: 'allow_substs' goes with 'from'")
            found.append(dict([_named(entity, parser)]))
    return found


def _named(entity: Entity, parser: Parser) -> tuple[tuple[Substitution, ...], Any]:
    name = tuple(parser.parse_substitution(entity.get_attr('name')))
    kind = entity.get_attr('type', optional=True)
    data_type = None if kind is None else _data_type(kind)
    value = entity.get_attr('value', data_type=data_type, optional=True)
    nested = entity.get_entities('param')
    entity.assert_entity_completely_parsed()
    if (value is None) == (not nested):
        raise LaunchError("<param> needs either the attribute 'value' or <param> tags in it")
    if nested:
        return name, dict(_named(item, parser) for item in nested)
    return name, ParameterValue(parser.parse_if_substitutions(value), value_type=data_type)


def _data_type(name: str) -> Any:
    known: dict[str, Any] = {'int': int, 'float': float, 'bool': bool, 'str': str}
    known |= {'list_of_int': list[int], 'list_of_float': list[float]}
    known |= {'list_of_bool': list[bool], 'list_of_str': list[str]}
    if name not in known:
        raise LaunchError(f"<param>: there is no type '{name}'; known are {', '.join(known)}")
    return known[name]
