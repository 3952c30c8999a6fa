"""The type checks of rosidl's setters, made only if ROS_PYTHON_CHECK_FIELDS=1 or check_fields=True is set.

The texts of the AssertionErrors are rosidl_generator_py's, since programs and their tests match on them.
"""

from __future__ import annotations

import math
from array import array
from collections import UserList, UserString
from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from typing import NoReturn

from goalwire.errors import UnknownFieldError
from goalwire.idl.model import FLOATS, FieldType, Shape, integer_range
from goalwire.idl.runtime import DTYPES, TYPECODES, Message, to_array, to_fixed

_FLOAT_LIMITS = {'float32': ('float', 3.402823466e38), 'float64': ('double', 1.7976931348623157e308)}
_SHOWN = 20  # field names that an error text lists at most
_PYTHON_TYPES: dict[str, type] = {'bool': bool, 'byte': bytes, 'string': str, 'wstring': str}


def python_type(type_: FieldType, message: type | None) -> type:
    """Return the Python type of a field's single value; `message` is the class of a nested message."""
    if message is not None:
        return message
    return _PYTHON_TYPES.get(type_.base) or (float if type_.base in FLOATS else int)


def checked(name: str, type_: FieldType, message: type | None, value: object) -> object:
    """Return the value as the field stores it; raises AssertionError if rosidl's setter would raise it."""
    if type_.shape is Shape.SINGLE:
        _check_single(name, type_, python_type(type_, message), value)
        return value
    if type_.is_number and type_.shape is Shape.ARRAY:
        return _checked_ndarray(name, type_, value)
    if type_.is_number:
        return _checked_array(name, type_, value)
    _check_collection(name, type_, python_type(type_, message), value)
    return value


def find_checks(message: Message, keywords: dict[str, object], usual: bool) -> object:
    """Return the value of a constructor's keyword check_fields, or `usual` if that was not given.

    Raises UnknownFieldError for other keywords, which are no fields' names; its text begins like rosidl's.
    """
    asked = keywords.pop('check_fields', usual)
    if keywords:
        _reject_unknown(message, keywords)
    return asked


def _reject_unknown(message: Message, unknown: dict[str, object]) -> NoReturn:
    from difflib import get_close_matches

    fields = list(message.get_fields_and_field_types())
    text = f'Invalid arguments passed to constructor: {", ".join(sorted(unknown))}'
    close = [match for name in unknown for match in get_close_matches(name, fields, n=1, cutoff=0.5)]
    has = f'has {", ".join(fields[:_SHOWN])}' if fields else 'has no fields'
    more = ', …' if len(fields) > _SHOWN else ''
    hint = f'did you mean {" and ".join(close)}?' if close else f'it {has}{more}'
    raise UnknownFieldError(f'{text}; {type(message).__name__} has no such field, {hint}')


def _fail(text: str) -> NoReturn:
    raise AssertionError(text)


def _check_single(name: str, type_: FieldType, wanted: type, value: object) -> None:
    field = f"The '{name}' field must be"
    if type_.is_message:
        if not isinstance(value, wanted):
            _fail(f"{field} a sub message of type '{wanted.__name__}'")
    elif type_.base == 'byte':
        if not isinstance(value, (bytes, bytearray)) or len(value) != 1:
            _fail(f"{field} of type 'bytes' or 'ByteString' with length 1")
    elif type_.string_capacity:
        if not isinstance(value, (str, UserString)) or len(value) > type_.string_capacity:
            _fail(f'{field} string value not longer than {type_.string_capacity}')
    elif not isinstance(value, wanted):
        _fail(f"{field} of type '{wanted.__name__}'")
    elif not _in_range(type_.base, value):
        if type_.base in FLOATS:
            kind, limit = _FLOAT_LIMITS[type_.base]
            _fail(f'{field} a {kind} in [{-limit}, {limit}]')
        low, high = integer_range(type_.base)
        _fail(f'{field} an {"integer" if low else "unsigned integer"} in [{low}, {high}]')


def _in_range(base: str, value: object) -> bool:
    if base in FLOATS:
        assert isinstance(value, float)
        return not abs(value) > _FLOAT_LIMITS[base][1] or math.isinf(value)
    if not isinstance(value, int) or base == 'bool':
        return True
    low, high = integer_range(base)
    return low <= value <= high


def _checked_ndarray(name: str, type_: FieldType, value: object) -> object:
    import numpy as np

    dtype = DTYPES[TYPECODES[type_.base]]
    if not isinstance(value, np.ndarray):
        _check_collection(name, type_, python_type(type_, None), value)
        return to_fixed(dtype, value, name)
    if value.dtype != dtype:
        _fail(f"The '{name}' numpy.ndarray() must have the dtype of 'numpy.{dtype}'")
    if value.size != type_.capacity:
        _fail(f"The '{name}' numpy.ndarray() must have a size of {type_.capacity}")
    return value


def _checked_array(name: str, type_: FieldType, value: object) -> object:
    typecode = TYPECODES[type_.base]
    if not isinstance(value, array):
        _check_collection(name, type_, python_type(type_, None), value)
        return to_array(typecode, value, name)  # type: ignore[arg-type]
    if value.typecode != typecode:
        _fail(f"The '{name}' array.array() must have the type code of '{typecode}'")
    if type_.shape is Shape.BOUNDED and len(value) > type_.capacity:
        _fail(f"The '{name}' array.array() must have a size <= {type_.capacity}")
    return value


def _check_collection(name: str, type_: FieldType, wanted: type, value: object) -> None:
    fits: Callable[[object], bool] = lambda item: isinstance(item, wanted) and _in_range(type_.base, item)  # noqa: E731
    good = (
        isinstance(value, (Sequence, AbstractSet, UserList))
        and not isinstance(value, (str, UserString))
        and not (type_.shape is Shape.ARRAY and len(value) != type_.capacity)
        and not (type_.shape is Shape.BOUNDED and len(value) > type_.capacity)
        and all(map(fits, value))
        and not (type_.string_capacity and any(len(item) > type_.string_capacity for item in value))
    )
    if not good:
        _fail(f"The '{name}' field must be {_collection_text(type_, wanted)}")


def _collection_text(type_: FieldType, wanted: type) -> str:
    text = 'a set or sequence'
    if type_.string_capacity:
        text += f' and each string value not longer than {type_.string_capacity}'
    if type_.shape is not Shape.UNBOUNDED:
        text += f' with length {"<= " if type_.shape is Shape.BOUNDED else ""}{type_.capacity}'
    text += f" and each value of type '{wanted.__name__}'"
    if type_.base in FLOATS:
        kind, limit = _FLOAT_LIMITS[type_.base]
        return f'{text} and each {kind} in [{-limit:f}, {limit:f}]'
    if type_.is_number:
        low, high = integer_range(type_.base)
        return f'{text} and each {"integer" if low else "unsigned integer"} in [{low}, {high}]'
    return text
