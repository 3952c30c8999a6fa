"""Fits plain data from YAML, JSON and forms to the fields of a message.

ROS 2's own `set_message_fields` converts whatever it gets: the text 'false' becomes true, 3.7 becomes 3, and
a text in place of a list becomes a list of its letters. If values become commands for a robot, such
conversions cause accidents. So `fit_fields` converts only unambiguous values, and refuses the rest with
field, type and an example:

    1 for a float, 3.0 for an integer, '1e-3' for a number    taken, as ROS 2's commands do
    0 and 1 for a bool                                        taken, as ROS 2's commands do
    005, on, 1.10 for a string, without quotes                taken as it was written
    'false' for a bool, 3.7 for an integer, true for a number, null, a text for a list    refused
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.errors import FieldValueError
from goalwire.idl.model import FLOATS, FieldType, MessageDefinition, Shape, integer_range
from goalwire.idl.registry import message_definition
from goalwire.records import record

if TYPE_CHECKING:
    import yaml

NOW = 'now'
"""A value that stands for the time when the message is sent."""
AUTO = 'auto'
"""A value that stands for a header whose stamp is the time when the message is sent."""
TIME = 'builtin_interfaces/msg/Time'
HEADER = 'std_msgs/msg/Header'
LARGEST_FLOAT32 = (2 - 2**-23) * 2.0**127

Primitive: TypeAlias = bool | int | float | str | bytes
_EXAMPLES = {'bool': 'true', 'string': "'a'", 'wstring': "'a'"}
_SHOWN = 60
"""The most characters of a value that an error's text shows."""


@record
class Written:
    """A value that YAML made of an unquoted text; string fields take the text, all others the value."""

    text: str
    value: object


# -- reading -------------------------------------------------------------------------------------------------


def read_yaml(text: str) -> Any:
    """Return the data of a YAML or JSON text; unquoted numbers, booleans and the like become `Written`.

    Raises FieldValueError with an empty path.
    """
    import yaml

    try:
        return _with_plain_keys(yaml.load(text, Loader=_loader()), {})  # noqa: S506 - a SafeLoader
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        problem = getattr(error, 'problem', None) or str(error).splitlines()[0]
        where = f' (line {mark.line + 1}, column {mark.column + 1})' if mark else ''
        raise FieldValueError('', f'that is not YAML: {problem}{where}') from None
    except RecursionError:
        raise FieldValueError('', 'that is nested too deeply') from None


@cache
def _loader() -> type[yaml.SafeLoader]:
    import yaml

    class Loader(yaml.SafeLoader):
        """Reads YAML and keeps the text of unquoted values."""

    for kind in ('bool', 'float', 'int', 'null', 'timestamp'):
        construct = yaml.SafeLoader.yaml_constructors[f'tag:yaml.org,2002:{kind}']

        def keep(loader: Loader, node: yaml.ScalarNode, construct: Any = construct) -> object:
            try:
                value = construct(loader, node)
            except ValueError:  # such as a date in month 13, or a number with thousands of digits
                value = node.value
            return Written(node.value, value) if node.style is None else value

        Loader.add_constructor(f'tag:yaml.org,2002:{kind}', keep)
    return Loader


def _with_plain_keys(data: Any, done: dict[int, Any]) -> Any:
    """Return the data with field names as texts: YAML makes a boolean of the field name `on`.

    `done` holds the result for each part, since YAML's aliases may refer to a part a billion times.
    """
    if not isinstance(data, Mapping | list):
        return data
    if id(data) not in done:
        done[id(data)] = (
            [_with_plain_keys(value, done) for value in data]
            if isinstance(data, list)
            else {
                key.text if isinstance(key, Written) else key: _with_plain_keys(value, done)
                for key, value in data.items()
            }
        )
    return done[id(data)]


def plain_values(data: Any, done: dict[int, Any] | None = None) -> Any:
    """Return data with YAML's values in place of `Written`, for fields whose types are unknown.

    `done` holds the result for each part, because YAML's aliases may refer to a part often.
    """
    done = {} if done is None else done
    if isinstance(data, Written):
        return data.value
    if not isinstance(data, Mapping | list | tuple):
        return data
    if id(data) not in done:
        done[id(data)] = (
            {name: plain_values(value, done) for name, value in data.items()}
            if isinstance(data, Mapping)
            else [plain_values(value, done) for value in data]
        )
    return done[id(data)]


# -- fitting -------------------------------------------------------------------------------------------------


def fit_fields(
    definition: MessageDefinition, values: Mapping[str, Any], path: str = '', *, stamps: bool = False
) -> dict[str, Any]:
    """Return values for a message's fields that `set_message_fields` takes without converting them.

    With `stamps` a time may be 'now' and a header 'auto'. Raises FieldValueError for the first value that
    does not fit.
    """
    known = {field.name: field.type for field in definition.fields}
    for name in values:
        if name not in known:
            there = ', '.join(known) or 'none'
            raise FieldValueError(path, f"there is no field '{name}'; the fields are: {there}")
    return {
        name: _fit(known[name], value, f'{path}.{name}' if path else name, stamps=stamps)
        for name, value in values.items()
    }


def fit_value(type_: FieldType, value: Any, path: str) -> Any:
    """Return the value, fitted to the type of a field or a parameter. Raises FieldValueError."""
    return _fit(type_, value, path, stamps=False)


def _fit(type_: FieldType, value: Any, path: str, *, stamps: bool) -> Any:
    if type_.shape is not Shape.SINGLE:
        return _fit_list(type_, value, path, stamps=stamps)
    if type_.is_message:
        return _fit_message(type_, value, path, stamps=stamps)
    return fit_single(type_.base, value, path, type_.string_capacity)


def _fit_message(type_: FieldType, value: Any, path: str, *, stamps: bool) -> Any:
    if stamps and ((type_.base == TIME and value == NOW) or (type_.base == HEADER and value == AUTO)):
        return value
    definition = message_definition(type_.base)
    if not isinstance(value, Mapping):
        fields = ', '.join(f'{field.name}: …' for field in definition.fields[:2])
        raise _misfit(path, f'the fields of a message such as {{{fields}}}', value, type_)
    return fit_fields(definition, value, path, stamps=stamps)


def _fit_list(type_: FieldType, value: Any, path: str, *, stamps: bool) -> Any:
    if isinstance(value, bytes) and type_.base in {'byte', 'char', 'uint8'}:
        value = list(value)  # YAML's !!binary gives bytes
    if not isinstance(value, list | tuple):
        raise _misfit(path, f'a list such as {_example_list(type_, value)}', value, type_)
    check_length(type_, len(value), path)
    single = FieldType(type_.base, string_capacity=type_.string_capacity)
    return [_fit(single, item, f'{path}[{index}]', stamps=stamps) for index, item in enumerate(value)]


def check_length(type_: FieldType, length: int, path: str) -> None:
    """Raise FieldValueError if an array or bounded sequence may not have `length` items."""
    count = type_.capacity
    if type_.shape is Shape.ARRAY and length != count:
        raise FieldValueError(path, f'there must be {count} items, not {length}', type_.text)
    if type_.shape is Shape.BOUNDED and length > count:
        raise FieldValueError(path, f'there may be {count} items at most, not {length}', type_.text)


def _example_list(type_: FieldType, value: Any) -> str:
    if type_.is_message:
        return '[{…}, {…}]'
    if type_.is_string and isinstance(value, str | Written):
        return f'[{_text_of(value)[:_SHOWN]}]'
    example = _EXAMPLES.get(type_.base, '1.5' if type_.base in FLOATS else '1')
    return f'[{example}, {example}]'


def fit_single(
    base: str, value: Any, path: str, string_capacity: int = 0
) -> bool | int | float | str | bytes:
    """Return the value, fitted to a primitive type; `string_capacity` is 0 for strings without a bound.

    Raises FieldValueError.
    """
    type_ = FieldType(base, string_capacity=string_capacity)
    if type_.is_string:
        return _fit_text(type_, value, path)
    if base == 'bool':
        return _fit_bool(type_, value, path)
    if base in FLOATS:
        return _fit_float(type_, value, path)
    return _fit_integer(type_, value, path)


def _fit_bool(type_: FieldType, value: Any, path: str) -> bool:
    plain = plain_values(value)
    if isinstance(plain, bool) or (type(plain) is int and plain in {0, 1}):
        return bool(plain)
    quoted = ' without quotes' if isinstance(plain, str) and plain.lower() in {'true', 'false'} else ''
    raise _misfit(path, f'true or false{quoted}', value, type_)


def _fit_text(type_: FieldType, value: Any, path: str) -> str:
    if isinstance(value, Written) and value.value is not None:
        value = value.text
    if not isinstance(value, str):
        example = "'a'" if isinstance(value, list | Mapping) else f'"{_show(value)}", in quotes'
        raise _misfit(path, f'a text such as {example}', value, type_)
    capacity = type_.string_capacity
    try:
        size = len(value.encode()) if type_.base == 'string' else len(value.encode('utf-16-le')) // 2
    except UnicodeEncodeError:
        raise FieldValueError(path, 'the text is not valid Unicode', type_.text) from None
    if '\0' in value:
        raise FieldValueError(path, 'a text cannot contain a NUL', type_.text)
    if 0 < capacity < size:
        unit = 'characters' if size == len(value) else 'bytes' if type_.base == 'string' else 'UTF-16 units'
        raise FieldValueError(path, f'{capacity} {unit} at most, not {size}', type_.text)
    return value


def _fit_float(type_: FieldType, value: Any, path: str) -> float:
    number = _number(value)
    if number is None:
        raise _misfit(path, 'a number such as 1.5', value, type_)
    try:
        fitted = float(number)
    except OverflowError:
        raise _misfit(path, 'a number that a double holds', value, type_) from None
    if type_.base == 'float32' and math.isfinite(fitted) and abs(fitted) > LARGEST_FLOAT32:
        raise _misfit(path, f'a number from {-LARGEST_FLOAT32:g} to {LARGEST_FLOAT32:g}', value, type_)
    return fitted


def _fit_integer(type_: FieldType, value: Any, path: str) -> int | bytes:
    if type_.base == 'byte' and isinstance(value, bytes) and len(value) == 1:
        return value
    number = _number(value)
    if number is None or (isinstance(number, float) and not number.is_integer()):
        raise _misfit(path, 'a whole number such as 3', value, type_)
    least, most = (0, 255) if type_.base == 'byte' else integer_range(type_.base)
    if not least <= number <= most:
        raise _misfit(path, f'a number from {least} to {most}', value, type_)
    return bytes((int(number),)) if type_.base == 'byte' else int(number)


def _number(value: Any) -> int | float | None:
    """Return a number, also for a text such as 1e-3, which YAML leaves a text; None for other values."""
    text = value.text if isinstance(value, Written) else value
    plain = value.value if isinstance(value, Written) else value
    number: object = _number_in(value) if isinstance(value, str) else plain
    if isinstance(number, bool) or not isinstance(number, int | float):
        return None
    too_large = isinstance(number, float) and math.isinf(number) and isinstance(text, str)
    # A number such as 1e999, which overflows to infinity, is refused.
    return None if too_large and 'inf' not in text.lower() else number


def _number_in(text: str) -> int | float | None:
    for read in (lambda digits: int(digits, 0), float):
        try:
            return read(text)
        except ValueError:
            continue
    return None


def _misfit(path: str, wanted: str, value: Any, type_: FieldType) -> FieldValueError:
    return FieldValueError(path, f'give {wanted}, not {_show(value)}', type_.text)


def _text_of(value: str | Written) -> str:
    return value.text if isinstance(value, Written) else value


def _show(value: Any) -> str:
    """Return a value as text in YAML's notation, cut to a limited length for error texts."""
    if isinstance(value, Written):
        text = value.text or 'nothing'
    elif value is None or isinstance(value, bool):
        text = {None: 'null', True: 'true', False: 'false'}[value]
    else:
        text = ''
        for piece in _pieces(value):
            text += piece
            if len(text) > _SHOWN:
                break
    return text if len(text) <= _SHOWN else text[: _SHOWN - 1] + '…'


def _pieces(value: Any) -> Iterator[str]:
    """Yield the parts of a value's text one by one: because of YAML's aliases the whole may be endless."""
    if isinstance(value, Mapping):
        for number, (name, item) in enumerate(value.items()):
            yield f'{", " if number else "{"}{name!r}: '
            yield from _pieces(item)
        yield '}' if value else '{}'
    elif isinstance(value, list | tuple):
        for number, item in enumerate(value):
            yield ', ' if number else '['
            yield from _pieces(item)
        yield ']' if value else '[]'
    else:
        yield repr(value.value if isinstance(value, Written) else value)
