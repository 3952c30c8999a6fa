"""The form of a message, made from its definition: fields, units, bounds, choices, defaults.

Values of a form are plain data, as YAML has them: numbers, texts, lists, and mappings for nested messages.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from decimal import Decimal, InvalidOperation
from typing import Any, Literal, TypeAlias

import yaml

from goalwire.errors import FieldValueError
from goalwire.idl.field_values import (
    AUTO,
    HEADER,
    LARGEST_FLOAT32,
    NOW,
    TIME,
    fit_single,
    plain_values,
    read_yaml,
)
from goalwire.idl.model import FLOATS, Field, MessageDefinition, Shape, integer_range
from goalwire.idl.registry import message_definition
from goalwire.observe.messages import interface_class
from goalwire.records import record

Kind: TypeAlias = Literal['bool', 'integer', 'float', 'text', 'time', 'message', 'list', 'messages']

_UNITS = frozenset(
    (
        *(
            'm',
            'mm',
            'cm',
            'km',
            's',
            'ms',
            'us',
            'ns',
            'min',
            'h',
            'rad',
            'deg',
            '°',
            'm/s',
            'm/s^2',
            'm/s²',
        ),
        *(
            'rad/s',
            'rad/s^2',
            'rad/s²',
            'kg',
            'g',
            'N',
            'Nm',
            'N*m',
            'Nm/rad',
            'J',
            'W',
            'Wh',
            'V',
            'A',
            'Ah',
        ),
        *('mAh', 'Hz', 'kHz', '%', 'Pa', 'bar', 'K', '°C', 'T', 'px', 'pixels'),
    )
)
_NUMBER = r'[-+]?\d+(?:\.\d+)?'
_RANGE = re.compile(rf'(?<![\w.])\[?\s*({_NUMBER})\s*(?:to|\.\.\.?|,)\s*({_NUMBER})\s*\]?(?![\w.])')
_ITEM = re.compile(
    r"""\s*(?:"(?P<double>(?:[^"\\]|\\.)*)"|'(?P<single>(?:[^']|'')*)'|(?P<plain>(?!\s*["'])[^,]*?))\s*(?:,|$)""",
    re.DOTALL,
)
_NEEDS_QUOTES = re.compile(r'^$|^[\s"\'\[]|\s$|[,\x00-\x1f\x7f-\x9f\u2028\u2029]')
_FIRST_WORD = re.compile(r'[:\s]*\(?([^\s,;:.()]+)')


@record
class FormField:
    """One line of a form, or a group of lines."""

    name: str
    kind: Kind
    type_text: str
    """The type as the definition writes it."""
    base: str
    comment: str = ''
    unit: str = ''
    least: float | None = None
    most: float | None = None
    hint: str = ''
    """The range in the field's comment. Values outside are accepted, because it is only a comment."""
    capacity: int | None = None
    """The most bytes of a text (UTF-16 units of a `wstring`), or items of a list."""
    exact: bool = False
    """True if a list has exactly `capacity` items."""
    choices: tuple[tuple[str, Any], ...] = ()
    """Names and values of the constants for this field."""
    fields: tuple[FormField, ...] = ()
    """The fields of a nested message, or of each item of a list of messages."""
    item_capacity: int | None = None
    """The most bytes, or UTF-16 units, of each text in a list."""


def form_of(type_name: str) -> tuple[FormField, ...]:
    """Return the form of 'pkg/msg/Name', or of a part: 'pkg/srv/Name_Request', 'pkg/action/Name_Goal'.

    Raises UnknownInterfaceError and InterfaceSyntaxError.
    """
    definition = message_definition(type_name)
    return tuple(_field(each, definition) for each in definition.fields)


def _field(field: Field, owner: MessageDefinition) -> FormField:
    kind = field.type
    comment = field.comment.strip()
    unit = field.unit or _unit(comment)
    text = kind.text
    found = _RANGE.search(comment)
    hint = f'{found[1]} to {found[2]}' if found else ''
    several = kind.shape is not Shape.SINGLE
    capacity = kind.capacity if kind.shape in {Shape.ARRAY, Shape.BOUNDED} else None
    exact = kind.shape is Shape.ARRAY
    nested = form_of(kind.base) if kind.is_message and kind.base != TIME else ()
    if kind.is_message and several:
        return FormField(
            field.name,
            'messages',
            text,
            kind.base,
            comment,
            unit,
            capacity=capacity,
            exact=exact,
            fields=nested,
        )
    if kind.base == TIME and not several:
        return FormField(field.name, 'time', text, kind.base, comment, unit)
    if kind.is_message:
        return FormField(field.name, 'message', text, kind.base, comment, unit, fields=nested)
    least, most = _bounds(kind.base)
    if several:
        return FormField(
            field.name,
            'list',
            text,
            kind.base,
            comment,
            unit,
            least,
            most,
            hint,
            capacity,
            exact,
            item_capacity=kind.string_capacity or None,
        )
    if kind.is_string:
        choices = _choices(field, owner)
        return FormField(
            field.name,
            'text',
            text,
            kind.base,
            comment,
            capacity=kind.string_capacity or None,
            choices=choices,
        )
    plain: Kind = 'bool' if kind.base == 'bool' else 'float' if kind.base in FLOATS else 'integer'
    choices = _choices(field, owner)
    return FormField(field.name, plain, text, kind.base, comment, unit, least, most, hint, choices=choices)


def _bounds(base: str) -> tuple[float | None, float | None]:
    if base == 'byte':
        return 0, 255
    if base == 'float32':
        return -LARGEST_FLOAT32, LARGEST_FLOAT32
    return integer_range(base) if 'int' in base or base == 'char' else (None, None)


def _unit(comment: str) -> str:
    """Return the unit with which a comment begins, as in `# rad, positive` or `# (m/s) forwards`."""
    found = _FIRST_WORD.match(comment)
    return found[1] if found and found[1] in _UNITS else ''


def _choices(field: Field, owner: MessageDefinition) -> tuple[tuple[str, Any], ...]:
    """Return the constants that name a field's values.

    These are the constants whose names begin with the field's name. If there are none and no other field has
    the same type, these are all constants of that type.
    """
    same = [constant for constant in owner.constants if constant.base == field.type.base]
    prefix = f'{field.name.upper()}_'
    named = [constant for constant in same if constant.name.startswith(prefix)]
    if not named and same:
        fellows = [each for each in owner.fields if each.type.base == field.type.base]
        named = [*same] if len(fellows) == 1 and field.type.shape is Shape.SINGLE else []
    return tuple((constant.name.removeprefix(prefix), constant.value) for constant in named)


# -- values --------------------------------------------------------------------------------------------------


def defaults_of(fields: tuple[FormField, ...], message: Any) -> dict[str, Any]:
    """Return the values of a new message; a stamp in a header is the time of sending."""
    from rosidl_runtime_py import message_to_ordereddict

    return _with_now(fields, dict(message_to_ordereddict(message)), in_header=False)


def new_item(field: FormField) -> dict[str, Any]:
    """Return the values of a new item of a list of messages."""
    return defaults_of(field.fields, interface_class(field.base)())


def complete(
    fields: tuple[FormField, ...], values: Mapping[str, Any], defaults: Mapping[str, Any]
) -> dict[str, Any]:
    """Return values for all fields; fields that are not in `values` get their defaults.

    `values` must come from `check`.
    """
    whole: dict[str, Any] = {}
    for field in fields:
        default = defaults.get(field.name)
        value = values.get(field.name, default)
        if field.kind == 'message' and isinstance(value, Mapping):
            whole[field.name] = complete(field.fields, value, default or {})
        elif field.kind == 'messages' and isinstance(value, list | tuple):
            item = new_item(field) if value else {}
            whole[field.name] = [complete(field.fields, each, item) for each in value]
        else:
            whole[field.name] = plain(value)
    return whole


def _with_now(fields: tuple[FormField, ...], values: dict[str, Any], *, in_header: bool) -> dict[str, Any]:
    known = {field.name: field for field in fields}
    for name, value in values.items():
        field = known.get(name)
        if field is None:
            continue
        if field.kind == 'time' and in_header:
            values[name] = NOW
        elif field.kind == 'message' and isinstance(value, dict):
            values[name] = _with_now(field.fields, dict(value), in_header=field.base == 'std_msgs/msg/Header')
    return values


def check(fields: tuple[FormField, ...], values: Mapping[str, Any], path: str = '') -> dict[str, Any]:
    """Return the values as they will be sent. Raises FieldValueError for the first value that is unfit."""
    known = {field.name: field for field in fields}
    for name in values:
        if name not in known:
            there = ', '.join(known) or 'none'
            raise FieldValueError(path, f"there is no field '{name}'; the fields are: {there}")
    return {
        name: _check_value(known[name], value, f'{path}.{name}' if path else str(name))
        for name, value in values.items()
    }


def _check_value(field: FormField, value: Any, path: str) -> Any:
    if field.kind == 'message':
        if field.base == HEADER and value == AUTO:
            return {'stamp': NOW}
        if not isinstance(value, Mapping):
            raise FieldValueError(path, f'give the fields of a {field.type_text}')
        return check(field.fields, value, path)
    if field.kind == 'time':
        return _time(value, path)
    if field.kind in {'list', 'messages'}:
        return _list(field, value, path)
    return _scalar(field, value, path)


def _list(field: FormField, value: Any, path: str) -> list[Any]:
    if isinstance(value, str):
        value = parse_list(value, path)
        if field.base == 'bool':
            value = [{'true': True, 'false': False}.get(item.lower(), item) for item in value]
    if not isinstance(value, list | tuple):
        raise FieldValueError(path, 'give a list: 1, 2, 3')
    if field.exact and len(value) != field.capacity:
        raise FieldValueError(path, f'there must be {field.capacity} items, not {len(value)}')
    if field.capacity is not None and len(value) > field.capacity:
        raise FieldValueError(path, f'there may be {field.capacity} items at most, not {len(value)}')
    if field.kind == 'messages':
        for number, item in enumerate(value):
            if not isinstance(item, Mapping):
                raise FieldValueError(f'{path}[{number}]', f'give the fields of a {field.base}')
        return [check(field.fields, item, f'{path}[{number}]') for number, item in enumerate(value)]
    return [_scalar(field, item, f'{path}[{number}]') for number, item in enumerate(value)]


def _scalar(field: FormField, value: Any, path: str) -> Any:
    """Return one value as it will be sent; a form gives only finite numbers."""
    capacity = field.capacity if field.kind == 'text' else field.item_capacity
    fitted = fit_single(field.base, value, path, capacity or 0)
    if isinstance(fitted, float) and not math.isfinite(fitted):
        raise FieldValueError(path, f'give a finite number, not {fitted} ({field.base})')
    return int.from_bytes(fitted) if isinstance(fitted, bytes) else fitted


def _number(value: Any, path: str) -> float:
    number = fit_single('float64', value, path)
    assert isinstance(number, float)
    if not math.isfinite(number):
        raise FieldValueError(path, 'give a finite number')
    return number


def _time(value: Any, path: str) -> Any:
    value = plain_values(value)
    if value in {NOW, AUTO} if isinstance(value, str) else False:
        return NOW
    if isinstance(value, Mapping):
        if set(value) <= {'sec', 'nanosec'}:
            return {name: int(_number(part, f'{path}.{name}')) for name, part in value.items()}
        raise FieldValueError(path, 'a time has sec and nanosec')
    if not 0 <= _number(value, path) < 2**31:
        raise FieldValueError(path, "give seconds since 1970, or 'now'")
    try:
        seconds = Decimal(str(value).strip())  # A float has too few digits for nanoseconds.
    except InvalidOperation:
        seconds = Decimal(_number(value, path))
    return {'sec': int(seconds), 'nanosec': int(seconds % 1 * 1_000_000_000)}


def parse_list(text: str, path: str = '') -> list[str]:
    """Read '1, 2, 3', or the same in brackets; the items are texts. Raises FieldValueError.

    An item must be in quotes if it contains a comma, begins with a quotation mark, or is empty. In "double"
    quotes backslashes work as in JSON; in 'single' quotes a quotation mark is doubled.
    """
    rest = text.strip()
    if rest.startswith('[') and rest.endswith(']') and not set(rest[1:-1]) & set('[]'):
        rest = rest[1:-1].strip()
    items: list[str] = []
    at = 0
    while at < len(rest):
        where = f'{path}[{len(items)}]'
        found = _ITEM.match(rest, at)
        if found is None:
            raise FieldValueError(where, 'what begins with a quotation mark must end with it, before a comma')
        at = found.end()
        if found['double'] is not None:
            try:
                items.append(json.loads(f'"{found["double"]}"', strict=False))
            except ValueError:
                raise FieldValueError(where, 'after a backslash comes one of " \\ / b f n r t u') from None
        elif found['single'] is not None:
            items.append(found['single'].replace("''", "'"))
        elif found['plain']:
            items.append(found['plain'])
        else:
            raise FieldValueError(where, "there is nothing before the comma; an empty text is ''")
    return items


def list_text(values: Sequence[Any]) -> str:
    """Write a list as `parse_list` reads it."""
    return ', '.join(_item_text(value) for value in values)


def _item_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and _NEEDS_QUOTES.search(value):
        return json.dumps(value, ensure_ascii=False) if value else "''"
    return str(value)


def time_text(value: Mapping[str, Any]) -> str:
    """Write a time in seconds, to the nanosecond."""
    nanoseconds = f'{value.get("nanosec", 0):09d}'.rstrip('0')
    return f'{value.get("sec", 0)}' + (f'.{nanoseconds}' if nanoseconds else '')


def shown_text(field: FormField, value: Any) -> str:
    """Return the text that a field of text shows for a value."""
    if isinstance(value, list):
        return list_text(value)
    if isinstance(value, Mapping):
        return time_text(value) if field.kind == 'time' else ''
    if value is None:
        return ''
    return str(value).lower() if isinstance(value, bool) else str(value)


def choice_titles(field: FormField, value: Any) -> dict[Any, str]:
    """Return the titles of a field's choices; `value` is one of them, too."""
    titles: dict[Any, str] = {}
    for title, choice in field.choices:
        titles[choice] = f'{titles[choice]}, {title}' if choice in titles else title
    titles = {choice: f'{title} ({choice})' for choice, title in titles.items()}
    return titles if value in titles else {value: f'{value}', **titles}


def parse_yaml(text: str) -> dict[str, Any]:
    """Read the values of a form from YAML or JSON. Raises FieldValueError."""
    value = read_yaml(text)
    if plain_values(value) is None:
        return {}
    if not isinstance(value, dict):
        raise FieldValueError('', 'give fields and values: data: 1')
    return value


def to_yaml(values: Any) -> str:
    """Write values as YAML, lists of numbers on one line."""
    text: str = yaml.dump(
        plain(values), allow_unicode=True, sort_keys=False, default_flow_style=None, width=100
    )
    return text


def in_one_line(value: Any) -> str:
    """Write a value as YAML on one line, for commands."""
    text: str = yaml.safe_dump(
        plain(value), default_flow_style=True, width=10**9, allow_unicode=True, sort_keys=False
    )
    return text.strip().removesuffix('\n...').strip()


def plain(value: Any) -> Any:
    """Convert mappings to dicts and sequences to lists, because YAML would name other classes."""
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def fill(cls: Any, values: Mapping[str, Any], now: Any) -> Any:
    """Return a message with these values; 'now' becomes the time message `now`. Raises FieldValueError."""
    from rosidl_runtime_py import set_message_fields

    message = cls()
    try:
        for stamp in set_message_fields(message, dict(values), expand_header_auto=True, expand_time_now=True):
            stamp(now)
    except (AssertionError, AttributeError, OverflowError, TypeError, ValueError) as error:
        raise FieldValueError('', ' '.join(str(error).split())) from None
    return message


def without_defaults(values: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Return the changes of a form: the values that differ from the message's defaults."""
    left: dict[str, Any] = {}
    for name, value in values.items():
        default = defaults.get(name)
        if isinstance(value, Mapping) and isinstance(default, Mapping):
            if inner := without_defaults(value, default):
                left[name] = inner
        elif value != default:
            left[name] = value
    return left
