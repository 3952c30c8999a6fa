"""Converts messages to rosbridge's JSON and CBOR, and back.

In JSON, arrays of uint8 and char are base64, and NaN and infinity are null, because JSON cannot express them.
In CBOR, arrays of numbers are typed arrays (RFC 8746, little endian), and arrays of uint8 are bytes. Reading
accepts all of these forms in both encodings, also `secs` and `nsecs` of ROS 1, and 'now' for a time. Sources:
the protocol's page, and rosbridge_library's message_conversion and cbor_conversion.
"""

from __future__ import annotations

import math
from array import array
from base64 import b64decode, b64encode
from binascii import Error as Base64Error
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from goalwire.cdr.layout import CODES
from goalwire.errors import FieldValueError
from goalwire.idl.field_values import HEADER, TIME, check_length, fit_value
from goalwire.idl.model import FLOATS, FieldType, Shape
from goalwire.idl.registry import message_definition
from goalwire.observe.messages import fields_of, interface_class

DURATION = 'builtin_interfaces/msg/Duration'
_OF_ROS_1 = {'secs': 'sec', 'nsecs': 'nanosec'}
_BYTES = {'uint8', 'char'}
_TAGS = {
    'uint16': 69, 'uint32': 70, 'uint64': 71, 'byte': 72, 'int8': 72, 'int16': 77, 'int32': 78, 'int64': 79,
    'float32': 85, 'float64': 86,
}  # fmt: skip
"""The tags of typed arrays in little endian."""
_CODE_OF_TAG = {
    64: 'u1', 68: 'u1', 69: '<u2', 70: '<u4', 71: '<u8', 72: 'i1', 77: '<i2', 78: '<i4', 79: '<i8',
    84: '<f2', 85: '<f4', 86: '<f8',
}  # fmt: skip


# -- from messages -------------------------------------------------------------------------------------------


def to_json(message: Any) -> dict[str, Any]:
    """Return a message in the form of rosbridge's JSON."""
    return {name: write(getattr(message, name)) for name, write in _json_plan(message.__class__)}


def to_cbor(message: Any) -> dict[str, Any]:
    """Return a message in the form of rosbridge's CBOR."""
    return {name: write(getattr(message, name)) for name, write in _cbor_plan(message.__class__)}


@cache
def _json_plan(cls: type) -> list[tuple[str, Callable[[Any], Any]]]:
    return [(field.name, _json_writer(field.type)) for field in fields_of(cls)]


@cache
def _cbor_plan(cls: type) -> list[tuple[str, Callable[[Any], Any]]]:
    return [(field.name, _cbor_writer(field.type)) for field in fields_of(cls)]


def _json_writer(type_: FieldType) -> Callable[[Any], Any]:
    if type_.shape is Shape.SINGLE:
        if type_.is_message:
            return to_json
        return _finite if type_.base in FLOATS else _number_of_byte if type_.base == 'byte' else _same
    if type_.is_message:
        return lambda items: [to_json(item) for item in items]
    if type_.base in _BYTES:
        return lambda items: b64encode(bytes(items)).decode('ascii')
    if type_.base in FLOATS:
        return _finite_items
    if type_.base == 'byte':
        return lambda items: [_number_of_byte(item) for item in items]
    return _items


def _cbor_writer(type_: FieldType) -> Callable[[Any], Any]:
    base = type_.base
    if type_.shape is Shape.SINGLE:
        return to_cbor if type_.is_message else _number_of_byte if base == 'byte' else _same
    if type_.is_message:
        return lambda items: [to_cbor(item) for item in items]
    if base in _BYTES:
        return bytes
    if base not in _TAGS:
        return list
    return lambda items: _make_typed_array(base, items)


def _make_typed_array(base: str, items: Any) -> Any:
    from cbor2 import CBORTag

    if base == 'byte':
        return CBORTag(_TAGS[base], b''.join(items))
    return CBORTag(_TAGS[base], np.asarray(items, dtype=f'<{CODES[base]}').tobytes())


def _same(value: Any) -> Any:
    return value


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _items(items: Any) -> list[Any]:
    return items.tolist() if hasattr(items, 'tolist') else list(items)


def _finite_items(items: Any) -> list[float | None]:
    if np.isfinite(np.asarray(items, dtype=float)).all():
        return _items(items)
    return [_finite(item) for item in _items(items)]


def _number_of_byte(value: Any) -> int:
    return value[0] if isinstance(value, bytes) else int(value)


# -- into messages -------------------------------------------------------------------------------------------


def from_values(cls: Any, values: object, now: Callable[[], Any], *, has_auto_header: bool = False) -> Any:
    """Return a message of a class from decoded JSON or CBOR. Missing fields keep their defaults.

    A list gives the fields in their order. `now` returns the time as a message, which is set in a header
    without a stamp, and with `has_auto_header` also in a missing header. Raises FieldValueError, with the
    path of the field.
    """
    message = cls()
    fields = {field.name: field.type for field in fields_of(cls)}
    if isinstance(values, list | tuple):
        if len(values) > len(fields):
            raise FieldValueError('', f'there are {len(fields)} fields, and {len(values)} values')
        values = dict(zip(fields, values, strict=False))
    reader = _Reader(now)
    reader.fill(message, fields, {} if values is None else values, '')
    if has_auto_header and fields.get('header') == FieldType(HEADER) and 'header' not in values:  # type: ignore[operator]
        message.header.stamp = now()
    return message


def number_items(value: object) -> object:
    """Return the numbers of a CBOR typed array as a numpy array, and any other value unchanged."""
    tag = getattr(value, 'tag', None)
    if tag not in _CODE_OF_TAG or not isinstance(getattr(value, 'value', None), bytes):
        return value
    try:
        return np.frombuffer(value.value, dtype=_CODE_OF_TAG[tag])  # type: ignore[attr-defined]
    except ValueError:
        raise FieldValueError('', 'a typed array ends within an item') from None


class _Reader:
    def __init__(self, now: Callable[[], Any]) -> None:
        self._now = now

    def fill(self, message: Any, fields: Mapping[str, FieldType], values: object, path: str) -> None:
        """Set the given fields of a message."""
        if not isinstance(values, Mapping):
            raise FieldValueError(path, f'give an object with the fields, not {type(values).__name__}')
        for name, value in values.items():
            if name not in fields:
                there = ', '.join(fields) or 'none'
                raise FieldValueError(path, f"there is no field '{name}'; the fields are: {there}")
            here = f'{path}.{name}' if path else name
            setattr(message, name, self._read(fields[name], getattr(message, name), value, here))

    def _read(self, type_: FieldType, old: Any, value: Any, path: str) -> Any:
        if type_.shape is not Shape.SINGLE:
            return self._read_items(type_, old, value, path)
        if not type_.is_message:
            if value is None and type_.base in FLOATS:
                return math.nan
            return fit_value(type_, value, path)
        return self._read_message(type_, value, path)

    def _read_message(self, type_: FieldType, value: Any, path: str) -> Any:
        if type_.base == TIME and value == 'now':
            return self._now()
        if type_.base in {TIME, DURATION} and isinstance(value, Mapping):
            value = {_OF_ROS_1.get(name, name): item for name, item in value.items()}
        message = interface_class(type_.base)()
        fields = {field.name: field.type for field in message_definition(type_.base).fields}
        if type_.base == HEADER and isinstance(value, Mapping):
            value = {'stamp': 'now'} | {name: item for name, item in value.items() if name != 'seq'}
        self.fill(message, fields, value, path)
        return message

    def _read_items(self, type_: FieldType, old: Any, value: Any, path: str) -> Any:
        value = number_items(value)
        if type_.base in _BYTES and isinstance(value, str):
            value = _from_base64(type_, value, path)
        if type_.is_message and isinstance(value, list | tuple):
            check_length(type_, len(value), path)
            single = FieldType(type_.base)
            return [self._read(single, None, item, f'{path}[{at}]') for at, item in enumerate(value)]
        fast = _fast_items(type_, value)
        if fast is None:
            plain = value.tolist() if isinstance(value, np.ndarray) else value
            if isinstance(plain, list) and type_.base in FLOATS:
                plain = [math.nan if item is None else item for item in plain]
            if isinstance(plain, bytes):
                plain = list(plain)
            fast = fit_value(type_, plain, path)
        return _as_slot(old, fast)


def _from_base64(type_: FieldType, text: str, path: str) -> bytes:
    try:
        return b64decode(text, validate=True)
    except (Base64Error, ValueError):
        raise FieldValueError(path, 'give a list of numbers, or base64', type_.text) from None


def _fast_items(type_: FieldType, value: Any) -> Any:
    """Return large bytes and typed arrays unchanged; None if each item must be checked."""
    if type_.shape is not Shape.UNBOUNDED or not type_.is_number:
        return None
    if isinstance(value, bytes) and type_.base in _BYTES:
        return value
    is_same = isinstance(value, np.ndarray) and value.dtype == np.dtype(f'<{CODES[type_.base]}')
    return value if is_same else None


def _as_slot(old: Any, items: Any) -> Any:
    """Return items in the container that the message class uses for the field."""
    if isinstance(old, array):
        made = array(old.typecode)
        if isinstance(items, bytes):
            made.frombytes(items)
        elif isinstance(items, np.ndarray):
            made.frombytes(items.tobytes())
        else:
            made.extend(items)
        return made
    if isinstance(old, np.ndarray):
        return np.array(items, dtype=old.dtype)
    return items
