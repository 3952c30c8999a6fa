"""The types of fields and the values in definitions, as classes with rosidl_adapter's names."""

from __future__ import annotations

import re
from typing import Final, TypeAlias

from goalwire.idl.literals import BOOLEANS
from rosidl_adapter._names import (
    VALID_MESSAGE_NAME_PATTERN,
    VALID_PACKAGE_NAME_PATTERN,
    InvalidResourceName,
    is_valid_message_name,
    is_valid_package_name,
)

Primitive: TypeAlias = bool | float | int | str

PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR: Final = '/'
ARRAY_UPPER_BOUND_TOKEN: Final = '<='  # noqa: S105 - no password
STRING_UPPER_BOUND_TOKEN: Final = '<='  # noqa: S105
PRIMITIVE_TYPES: Final = [
    'bool', 'byte', 'char', 'float32', 'float64', 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32',
    'int64', 'uint64', 'string', 'wstring', 'duration', 'time',
]  # fmt: skip
_STRINGS = ('string', 'wstring')


class InvalidValue(Exception):
    """An error for a text that is not a value of the field's or constant's type."""

    def __init__(self, type_: Type | str, value_string: str, message_suffix: str | None = None) -> None:
        text = f"value '{value_string}' can not be converted to type '{type_}'"
        super().__init__(text if message_suffix is None else f'{text}: {message_suffix}')


class BaseType:
    """A type without array brackets: a primitive (`pkg_name` is None) or a message.

    `context_package_name` is the package of messages that are named without a package. Raises
    InvalidResourceName, and TypeError for a bound that is not a positive number.
    """

    __slots__ = ['pkg_name', 'string_upper_bound', 'type']

    pkg_name: str | None
    type: str
    string_upper_bound: int | None

    def __init__(self, type_string: str, context_package_name: str | None = None) -> None:
        self.pkg_name = self.string_upper_bound = None
        name, token, bound = type_string.partition(STRING_UPPER_BOUND_TOKEN)
        if type_string in PRIMITIVE_TYPES:
            self.type = type_string
        elif token and name in _STRINGS:
            self.type = name
            self.string_upper_bound = _positive(
                bound, f"the upper bound of the string type '{type_string}' must be a valid integer value > 0"
            )
        else:
            self.pkg_name, self.type = _message(type_string, context_package_name)

    def is_primitive_type(self) -> bool:
        """Return whether the type is a primitive, not a message."""
        return self.pkg_name is None

    def _base_text(self) -> str:
        if self.pkg_name is not None:
            return f'{self.pkg_name}{PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR}{self.type}'
        bound = f'{STRING_UPPER_BOUND_TOKEN}{self.string_upper_bound}' if self.string_upper_bound else ''
        return self.type + bound

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BaseType) and self._base_text() == other._base_text()

    def __hash__(self) -> int:
        return hash(str(self))

    def __str__(self) -> str:
        return self._base_text()


class Type(BaseType):
    """A type with its array brackets, if it has any. Raises the errors of BaseType."""

    __slots__ = ['array_size', 'is_array', 'is_upper_bound']

    is_array: bool
    array_size: int | None
    is_upper_bound: bool

    def __init__(self, type_string: str, context_package_name: str | None = None) -> None:
        self.is_array = type_string[-1] == ']'
        self.array_size, self.is_upper_bound = None, False
        if self.is_array:
            base, bracket, size = type_string[:-1].rpartition('[')
            if not bracket:
                raise TypeError(f"the type {type_string} ends with ']' but does not contain a '['")
            self.is_upper_bound = size.startswith(ARRAY_UPPER_BOUND_TOKEN)
            if size:
                self.array_size = _positive(
                    size.removeprefix(ARRAY_UPPER_BOUND_TOKEN),
                    f"the size of array type '{type_string}' must be a valid integer value > 0 "
                    f"optionally prefixed with '{ARRAY_UPPER_BOUND_TOKEN}' if it is only an upper bound",
                )
            type_string = base
        super().__init__(type_string, context_package_name)

    def is_dynamic_array(self) -> bool:
        """Return whether the type is an array without a fixed size."""
        return self.is_array and (not self.array_size or self.is_upper_bound)

    def is_fixed_size_array(self) -> bool:
        """Return whether the type is an array with a fixed size."""
        return self.is_array and bool(self.array_size) and not self.is_upper_bound

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Type) and str(self) == str(other)

    def __hash__(self) -> int:
        return hash(str(self))

    def __str__(self) -> str:
        if not self.is_array:
            return self._base_text()
        bound = ARRAY_UPPER_BOUND_TOKEN if self.is_upper_bound else ''
        return f'{self._base_text()}[{bound}{"" if self.array_size is None else self.array_size}]'


def parse_value_string(type_: Type, value_string: str) -> Primitive | list[Primitive]:
    """Parse the default value of a field: one value, or [a, b, …].

    Raises InvalidValue, and NotImplementedError for messages, which have no defaults.
    """
    if not type_.is_primitive_type():
        raise NotImplementedError(f"parsing string values into type '{type_}' is not supported")
    if not type_.is_array:
        return parse_primitive_value_string(type_, value_string)
    if not (value_string.startswith('[') and value_string.endswith(']')):
        raise InvalidValue(type_, value_string, "array value must start with '[' and end with ']'")
    inside = value_string[1:-1]
    if type_.type in _STRINGS:
        items = parse_string_array_value_string(inside, type_.array_size)
    else:
        items = inside.split(',') if inside else []
    if type_.array_size and (
        len(items) > type_.array_size if type_.is_upper_bound else len(items) != type_.array_size
    ):
        wanted = 'not more than' if type_.is_upper_bound else 'exactly'
        raise InvalidValue(
            type_, value_string, f'array must have {wanted} {type_.array_size} elements, not {len(items)}'
        )
    return [_element(type_, value_string, index, item.strip()) for index, item in enumerate(items)]


def parse_string_array_value_string(element_string: str, expected_size: int | None) -> list[str]:
    """Split the text of an array at commas outside quotes, and return the strings without their quotes.

    Raises ValueError for quotes that do not match, and for a comma where a string should be.
    """
    items: list[str] = []
    rest = element_string.strip(' ')
    while rest:
        if rest[0] == ',':
            raise ValueError(f"unexpected ',' at beginning of [{rest}]")
        if rest[0] in '"\'':
            end = find_matching_end_quote(rest, rest[0])
            if end == -1:
                raise ValueError(f'string [{rest}] incorrectly quoted\n{items}')
            items.append(rest[1 : end + 1].replace('\\' + rest[0], rest[0]))
            rest = rest[end + 2 :].lstrip(' ')
        else:
            item, comma, rest = rest.partition(',')
            items.append(item)
            rest = comma + rest
        rest = rest.removeprefix(',').lstrip(' ')
    return items


def find_matching_end_quote(string: str, quote: str) -> int:
    """Return how many characters are between the quote string[0] and the closing quote; -1 without it."""
    found = re.compile(rf'{quote}((?:\\.|[^\\{quote}])*){quote}', re.DOTALL).match(string)
    return len(found[1]) if found else -1


def parse_primitive_value_string(type_: Type, value_string: str) -> Primitive:
    """Parse one value of a primitive type. Raises InvalidValue, and ValueError for any other type."""
    if not type_.is_primitive_type() or type_.is_array:
        raise ValueError('the passed type must be a non-array primitive type')
    name = type_.type
    if name == 'bool':
        if value_string.lower() not in BOOLEANS:
            raise InvalidValue(name, value_string, "must be either 'true' / '1' or 'false' / '0'")
        return BOOLEANS[value_string.lower()]
    if name in _STRINGS:
        return _string(type_, value_string)
    if name in ('float32', 'float64'):
        try:
            return float(value_string)
        except ValueError:
            raise InvalidValue(
                name, value_string, "must be a floating point number using '.' as the separator"
            ) from None
    if name in ('time', 'duration'):
        raise AssertionError(f"unknown primitive type '{name}'")
    return _integer(name, value_string)


def _message(text: str, context_package: str | None) -> tuple[str, str]:
    """Return the package and the name of a message."""
    parts = text.split(PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR)
    if len(parts) == 1 and context_package:
        parts.insert(0, context_package)
    if len(parts) != 2:
        raise InvalidResourceName(text)
    package, name = parts
    if not is_valid_package_name(package):
        raise InvalidResourceName(
            f"'{package}' is an invalid package name. "
            f"It should have the pattern '{VALID_PACKAGE_NAME_PATTERN.pattern}'"
        )
    if not is_valid_message_name(name):
        raise InvalidResourceName(
            f"'{name}' is an invalid message name. "
            f"It should have the pattern '{VALID_MESSAGE_NAME_PATTERN.pattern}'"
        )
    return package, name


def _positive(text: str, problem: str) -> int:
    try:
        number = int(text)
    except ValueError:
        raise TypeError(problem) from None
    if number <= 0:
        raise TypeError(problem)
    return number


def _element(type_: Type, whole: str, index: int, text: str) -> Primitive:
    try:
        return parse_primitive_value_string(Type(BaseType.__str__(type_)), text)
    except InvalidValue as error:
        raise InvalidValue(type_, whole, f'element {index} with {error}') from None


def _integer(name: str, text: str) -> int:
    unsigned = name[0] == 'u' or name in ('byte', 'char')
    bits = 8 if name in ('byte', 'char') else int(name.lstrip('uint'))
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    problem = InvalidValue(name, text, f'must be a valid integer value >= {low} and <= {high}')
    try:
        value = int(text)
    except ValueError:
        try:
            value = int(text, 0)  # 0x10, 0b101
        except ValueError:
            raise problem from None
    if not low <= value <= high:
        raise problem
    return value


def _string(type_: Type, text: str) -> str:
    for quote in ('"', "'"):
        if text.startswith(quote) and text.endswith(quote):
            text = text[1:-1]
            if re.search(rf'(?<!\\){quote}', text):
                raise InvalidValue(type_.type, text, 'string inner quotes not properly escaped')
            text = text.replace('\\' + quote, quote)
            break
    if type_.string_upper_bound and len(text) > type_.string_upper_bound:
        raise InvalidValue(
            Type(BaseType.__str__(type_)),
            text,
            f'string must not exceed the maximum length of {type_.string_upper_bound} characters',
        )
    return text
