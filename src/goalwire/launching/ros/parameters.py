"""Parameters of nodes in launch files, and their evaluation to the values that nodes get.

Values are Python values, substitutions, lists and nested mappings. As in launch_ros, the text of a
substitution is parsed by YAML's rules; a plain string in the launch file stays a string.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from shutil import rmtree
from typing import Any, TypeAlias

import yaml

from goalwire.errors import BadLaunchValueError, LaunchError, SubstitutionFailure
from goalwire.files import show
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.notation import parse_substitution
from goalwire.launching.values import (
    SCALARS,
    describe_text,
    is_substitution,
    normalize_to_list_of_substitutions,
    normalize_typed_substitution,
    perform_substitutions,
    perform_text,
    perform_typed_substitution,
    truth,
)

SomeParameters: TypeAlias = Sequence[Any]
_NO_SEQUENCE = (
    'Expected a non-empty sequence whose items are all bool, all int, all float or all str, but got {!r:.100}'
)


class ParameterValue:
    """A parameter's value whose type is given, for example because a substitution gives the value."""

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self._value = normalize_typed_substitution(value, value_type)
        self._value_type = value_type
        self._evaluated: Any = None

    @property
    def value(self) -> Any:
        """The value as in the launch file; after evaluate() the evaluated value."""
        return self._value if self._evaluated is None else self._evaluated

    @property
    def value_type(self) -> Any:
        return self._value_type

    def evaluate(self, context: LaunchContext) -> Any:
        """Evaluate the value. Raises BadLaunchValueError if it does not have the given type."""
        if self._value_type is None and is_substitution(self._value):
            found = by_yaml(perform_substitutions(context, self._value))
            self._evaluated = list(found) if isinstance(found, tuple) else found
            return self._evaluated
        try:
            self._evaluated = perform_typed_substitution(context, self._value, self._value_type)
        except ValueError as error:
            raise BadLaunchValueError(f'a parameter value: {error}') from error
        return self._evaluated


class Parameter:
    """One parameter of a node: its name and value."""

    def __init__(self, name: SomeSubstitutions, value: Any, *, value_type: Any = None) -> None:
        self._name = normalize_to_list_of_substitutions(name)
        self._value = ParameterValue(value, value_type=value_type)
        self._evaluated_name: str | None = None

    @property
    def name(self) -> list[Substitution] | str:
        """The name as in the launch file; after evaluate() the evaluated name."""
        return self._name if self._evaluated_name is None else self._evaluated_name

    @property
    def value(self) -> Any:
        return self._value.value

    @property
    def value_type(self) -> Any:
        return self._value.value_type

    def evaluate(self, context: LaunchContext) -> tuple[str, Any]:
        self._evaluated_name = perform_substitutions(context, self._name)
        return self._evaluated_name, self._value.evaluate(context)


class ParameterFile:
    """A parameter file; with `allow_substs` the substitutions $(…) in the file are evaluated first."""

    def __init__(
        self, param_file: SomeSubstitutions, *, allow_substs: bool | SomeSubstitutions = False
    ) -> None:
        self._file = normalize_to_list_of_substitutions(param_file)
        self._allow_substs = allow_substs
        self._evaluated: Path | None = None
        self._written: Path | None = None

    @property
    def param_file(self) -> list[Substitution] | Path:
        """The path in the launch file; after evaluate() the path that the node reads."""
        return self._file if self._evaluated is None else self._evaluated

    @property
    def allow_substs(self) -> bool | SomeSubstitutions:
        return self._allow_substs

    def evaluate(self, context: LaunchContext) -> Path:
        """Return the path of the file that the node will read. Raises LaunchError if it cannot be read."""
        path = Path(perform_substitutions(context, self._file))
        allowed = (
            self._allow_substs if isinstance(self._allow_substs, bool) else truth(context, self._allow_substs)
        )
        self._evaluated = path
        if not allowed:
            return path
        try:
            plain = yaml.safe_dump(yaml.safe_load(path.read_text(encoding='utf-8')))
            text = perform_substitutions(context, parse_substitution(plain))
            yaml.safe_load(text)
        except (yaml.YAMLError, UnicodeError) as error:
            raise SubstitutionFailure(
                f'the parameter file {show(str(path))} is not valid YAML: {" ".join(str(error).split())}'
            ) from error
        self._evaluated = self._written = write_temporary(context, text)
        return self._written

    def cleanup(self) -> None:
        """Remove the file that evaluate() has written, before the end of the launch would remove it."""
        if self._written is not None:
            self._written.unlink(missing_ok=True)
            self._evaluated = self._written = None


def write_temporary(context: object, text: str) -> Path:
    """Write a parameter file that is removed when the launch has ended.

    With a mock context in a test, no launch ends, so the caller has to remove the file.
    """
    folder = _temporary_folder(context) if isinstance(context, LaunchContext) else None
    descriptor, path = tempfile.mkstemp(prefix='launch_params_', suffix='.yaml', dir=folder)
    with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
        file.write(text)
    return Path(path)


def _temporary_folder(context: LaunchContext) -> str:
    """Return the folder of this launch's temporary parameter files, made when it is first needed."""
    globals_ = context.get_globals()
    folder = globals_.get('launch_params_folder')
    if folder is None:
        folder = tempfile.mkdtemp(prefix='launch_params_')
        context.extend_globals({'launch_params_folder': folder})

        def remove() -> None:
            context.remove_globals(['launch_params_folder'])
            rmtree(folder, ignore_errors=True)

        context.cleanups.append(remove)
    return str(folder)


def normalize_parameters(parameters: Any) -> tuple[Any, ...]:
    """Turn a node's `parameters` in a launch file into ParameterFiles and mappings. Raises TypeError."""
    if isinstance(parameters, str | Mapping) or not isinstance(parameters, Sequence):
        raise TypeError(f'parameters are a list of mappings and of parameter files, not {parameters!r:.100}')
    return tuple(
        item
        if isinstance(item, Parameter | ParameterFile)
        else normalize_parameter_dict(item)
        if isinstance(item, Mapping)
        else ParameterFile(item)
        for item in parameters
    )


def normalize_parameter_dict(parameters: Mapping[Any, Any]) -> dict[tuple[Substitution, ...], Any]:
    """Prepare names and values of a mapping for evaluate_dictionary(). Raises TypeError."""
    if not isinstance(parameters, Mapping):
        raise TypeError(f'expected a mapping of parameters, got {parameters!r:.100}')
    return {
        tuple(normalize_to_list_of_substitutions(name)): normalize_parameter_dict(value)
        if isinstance(value, Mapping)
        else _check_named(name, value)
        for name, value in parameters.items()
    }


def _check_named(name: Any, value: Any) -> Any:
    """Return the value if a parameter can have it. Raises BadLaunchValueError with the parameter's name."""
    try:
        return _check(value)
    except TypeError as error:
        shown_name = (
            name if isinstance(name, str) else describe_text(normalize_to_list_of_substitutions(name))
        )
        raise BadLaunchValueError(f"parameter '{shown_name}': {error}") from error


def _is_text(item: Sequence[Any]) -> bool:
    return all(isinstance(part, str | Substitution) for part in item)


def _check(value: Any) -> Any:
    """Return the value, prepared, if a parameter can have it. Raises TypeError for any other value."""
    if isinstance(value, bool | int | float | str | bytes | Path | Substitution | ParameterValue):
        return value
    if hasattr(value, 'tolist'):  # numpy scalars
        return _check(value.tolist())
    if isinstance(value, Sequence):
        if all(not isinstance(item, list | tuple) or _is_text(item) for item in value):
            return [item if isinstance(item, list | tuple) else _check(item) for item in value]
        raise TypeError(f'{value!r:.100} has nested lists, which no parameter can have')
    raise TypeError(f'{value!r:.100} is neither a number, a boolean, a string, bytes nor a list of them')


def evaluate_parameters(context: LaunchContext, parameters: Iterable[Any]) -> tuple[Any, ...]:
    """Evaluate normalized parameters: to paths of files, and to mappings from full names to values.

    Raises BadLaunchValueError for a value that no parameter can have.
    """
    found: list[Any] = []
    for item in parameters:
        if isinstance(item, ParameterFile):
            found.append(item.evaluate(context))
        elif isinstance(item, Parameter):
            found.append(dict([item.evaluate(context)]))
        elif isinstance(item, Mapping):
            found.append(evaluate_dictionary(context, item))
        else:
            raise TypeError(f'expected a mapping of parameters or a parameter file, got {item!r:.100}')
    return tuple(found)


def evaluate_dictionary(
    context: LaunchContext, parameters: Mapping[Any, Any], prefix: str = ''
) -> dict[str, Any]:
    """Evaluate a mapping to values by full names; nested names are joined by a dot, as in `arm.reach`."""
    found: dict[str, Any] = {}
    for key, value in parameters.items():
        name = prefix + perform_text(context, key)
        if isinstance(value, Mapping):
            found |= evaluate_dictionary(context, value, f'{name}.')
        else:
            try:
                found[name] = evaluate_value(context, value)
            except (TypeError, ValueError) as error:
                raise BadLaunchValueError(f"parameter '{name}': {error}") from error
    return found


def evaluate_value(context: LaunchContext, value: Any) -> Any:
    """Evaluate one value; a list becomes a tuple. Raises TypeError for a value that no parameter can have."""
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
    if hasattr(value, 'tolist'):  # numpy scalars
        return evaluate_value(context, value.tolist())
    raise TypeError(f'{value!r:.100} is neither a number, a boolean, a string, bytes nor a list of them')


def _item(context: LaunchContext, item: Any) -> Any:
    if isinstance(item, Sequence) and not isinstance(item, str | bytes):
        return by_yaml(perform_text(context, item))
    return evaluate_value(context, item)


def by_yaml(text: str) -> Any:
    """Parse a text by YAML's rules. Raises BadLaunchValueError for a value that no parameter can have.

    A text that is not valid YAML or has no content is returned unchanged.
    """
    try:
        found = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    if isinstance(found, list):
        if not found:
            raise BadLaunchValueError(_NO_SEQUENCE.format(found))
        return _uniform(found)
    if isinstance(found, Mapping | set):
        raise BadLaunchValueError(
            'Allowed value types are bytes, bool, int, float, str and sequences of one of them, '
            f"but '{text:.100}' is a {type(found).__name__}; "
            'ParameterValue(…, value_type=str), or type="str" of <param>, keeps it a text'
        )
    return found if isinstance(found, SCALARS) else text


def _uniform(items: list[Any]) -> tuple[Any, ...]:
    kinds = {type(item) for item in items}
    if not items or (len(kinds) == 1 and kinds <= set(SCALARS)):
        return tuple(items)
    if kinds <= {int, float}:
        return tuple(float(item) for item in items)
    raise BadLaunchValueError(_NO_SEQUENCE.format(items))


def as_rule(name: str, value: Any) -> str:
    """Return a parameter as `name:=value` for the command line, with the value as YAML."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
    return f'{name}:={text.removesuffix("...").strip()}'


def as_file(node: str, parameters: Mapping[str, Any]) -> str:
    """Return the text of a parameter file for one node, or for '/**'."""
    return yaml.safe_dump({node: {'ros__parameters': dict(parameters)}}, default_flow_style=False)


def parse_parameters(entities: Sequence[Entity], parser: Parser) -> list[Any]:
    """Read the <param> tags of a node."""
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
            found.append(dict([_read_name(entity, parser)]))
    return found


def _read_name(entity: Entity, parser: Parser) -> tuple[tuple[Substitution, ...], Any]:
    name = tuple(parser.parse_substitution(entity.get_attr('name')))
    kind = entity.get_attr('type', optional=True)
    data_type = None if kind is None else _data_type(kind)
    value = entity.get_attr('value', data_type=data_type, optional=True)
    nested = entity.get_entities('param')
    entity.assert_entity_completely_parsed()
    if (value is None) == (not nested):
        raise LaunchError("<param> needs either the attribute 'value' or <param> tags in it")
    if nested:
        return name, dict(_read_name(item, parser) for item in nested)
    try:
        return name, ParameterValue(parser.parse_if_substitutions(value), value_type=data_type)
    except BadLaunchValueError as error:
        raise BadLaunchValueError(f"parameter '{entity.get_attr('name')}': {error}") from error


def _data_type(name: str) -> Any:
    known: dict[str, Any] = {'int': int, 'float': float, 'bool': bool, 'str': str}
    known |= {'list_of_int': list[int], 'list_of_float': list[float]}
    known |= {'list_of_bool': list[bool], 'list_of_str': list[str]}
    if name not in known:
        raise LaunchError(f"<param>: there is no type '{name}'; known are {', '.join(known)}")
    return known[name]
