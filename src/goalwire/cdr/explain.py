"""Explains a failure of the codec: a slow second pass that finds the field, its value and its offset."""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Collection, Iterator
from typing import TypeVar

from goalwire.cdr import layout, reading
from goalwire.cdr.layout import HEADER_SIZE, Leaf
from goalwire.errors import DecodeError, EncodeError, EncodeTypeError, EncodeValueError
from goalwire.idl.model import FLOATS, Shape, integer_range
from goalwire.idl.rosidl_compat import type_name
from goalwire.idl.runtime import DTYPES, TYPECODES

_FLOAT32_LIMIT = 3.4028235677973366e38  # the smallest magnitude that rounds to infinity as float32
_LITTLE_ENDIAN, _BIG_ENDIAN = 1, 0  # representation identifiers; XCDR2's are 6 to 11, parameter lists 2 and 3

E = TypeVar('E', bound=Exception)


def raising(read: str) -> list[str]:
    """Return the last lines of a generated encoder or decoder: they raise `failure`, whose traceback keeps
    the frame.

    The lines delete the frame's reference to `failure`, which would be a circle, and to the data in the
    variable `read`.
    """
    return ['    try:', '        raise failure', '    finally:', f'        del failure, {read}']


def explain_encode(cls: type, message: object, error: Exception) -> EncodeError:
    """Return the error to raise for a message that an encoder refused; the error does not refer to the
    message.
    """
    return _detach(_encode_error(cls, message, error))


def _encode_error(cls: type, message: object, error: Exception) -> EncodeError:
    try:
        if not isinstance(message, cls):
            return EncodeTypeError(type_name(cls), '', f'expected {cls.__name__}, got {_show(message)}')
        for path, leaf, value in _values(cls, message, ''):
            _judge(type_name(cls), path, leaf, value)
    except EncodeError as found:
        found.__context__ = None  # `found` contains all facts of the encoder's error
        return found.with_traceback(None)
    except Exception as other:
        return EncodeValueError(type_name(cls), '', f'cannot be encoded: {other!r}')
    return EncodeValueError(type_name(cls), '', f'cannot be encoded: {error!r}')


def _values(cls: type, message: object, prefix: str) -> Iterator[tuple[str, Leaf, object]]:
    """Yield path, field and value of each field of a message; nested fields come after the field that
    contains them.
    """
    for leaf in layout.leaves(cls):
        path = prefix + leaf.name
        value = getattr(message, leaf.name if leaf.is_packed else f'_{leaf.name}', None)
        yield path, leaf, value
        if leaf.cls is None:
            continue
        if leaf.type.shape is Shape.SINGLE:
            yield from _values(leaf.cls, value, f'{path}.')
        elif isinstance(value, Collection):
            for index, item in enumerate(value):
                yield from _values(leaf.cls, item, f'{path}[{index}].')


def _judge(root: str, path: str, leaf: Leaf, value: object) -> None:
    """Raise an EncodeError if a value does not fit its field."""
    if leaf.type.shape is Shape.SINGLE:
        _judge_single(root, path, leaf, value)
        return
    if not isinstance(value, Collection):
        raise EncodeTypeError(root, path, f'expected a sequence, got {_show(value)}')
    if isinstance(value, str):
        raise EncodeTypeError(
            root, path, f'expected a list, got {_show(value)}{_where_set(path, f" = [{_brief(value)}]")}'
        )
    size = int(getattr(value, 'size', len(value)))
    capacity = leaf.type.capacity
    if leaf.type.shape is Shape.ARRAY and size != capacity:
        hint = f'write a list of {capacity} values, or leave the field out'
        raise EncodeValueError(root, path, f'expected exactly {capacity} values, got {size} ({hint})')
    if leaf.type.shape is Shape.BOUNDED and size > capacity:
        raise EncodeValueError(root, path, f'expected at most {capacity} values, got {size}')
    if leaf.type.is_number and leaf.type.shape is Shape.ARRAY:
        dtype = DTYPES[TYPECODES[leaf.type.base]]
        if str(getattr(value, 'dtype', '')) != dtype:
            raise EncodeTypeError(root, path, f'expected a numpy array of {dtype}, got {_show(value)}')
    elif not (isinstance(value, array) and value.typecode == TYPECODES.get(leaf.type.base)):
        octets = leaf.type.base == 'byte' and isinstance(value, (bytes, bytearray))
        for index, item in enumerate(() if octets else value):
            _judge_single(root, f'{path}[{index}]', leaf, item)


def _judge_single(root: str, path: str, leaf: Leaf, value: object) -> None:
    base = leaf.type.base
    if leaf.cls is not None:
        if not isinstance(value, leaf.cls):
            raise EncodeTypeError(root, path, _explain_nested(path, leaf.cls, value))
    elif leaf.type.is_string:
        _judge_text(root, path, leaf, value)
    elif base == 'bool':
        if not isinstance(value, bool):
            raise EncodeTypeError(root, path, f'expected bool, got {_show(value)} (write {_as_bool(value)})')
    elif base == 'byte':
        if not isinstance(value, bytes) or len(value) != 1:
            raise EncodeTypeError(root, path, f'expected bytes of length 1, got {_show(value)}')
    elif base in FLOATS:
        _judge_float(root, path, base, value)
    else:
        _judge_integer(root, path, base, value)


def _explain_nested(path: str, cls: type, value: object) -> str:
    """Return a text that says which value was given in place of a nested message, and what to write."""
    if hasattr(value, 'to_msg'):  # a Time or Duration of rclpy
        name = type(value).__name__
        example = 'node.get_clock().now()' if name == 'Time' else 'Duration(seconds=1)'
        return (
            f'expected {type_name(cls)}, got a {name} of rclpy: write .to_msg() behind it where the program '
            f'sets this field, as in {path.rpartition(".")[2]}={example}.to_msg()'
        )
    leaves = layout.leaves(cls)
    names = [leaf.name for leaf in leaves]
    written = f'.{names[0]} = …' if names else f' = {cls.__name__}()'
    if path.endswith(']'):
        written = f' = {cls.__name__}({", ".join(f"{name}=…" for name in names[:3])})'
    elif isinstance(value, dict) and value and set(value) <= set(names):
        name, inner = next(iter(value.items()))
        written = f'.{name} = {_brief(inner)}{", and so on" if len(value) > 1 else ""}'
    elif isinstance(value, float) and leaves and leaves[0].type.base in FLOATS:
        written = f'.{names[0]} = {_brief(value)}'
    return f'expected {cls.__name__}, got {_show(value)}{_where_set(path, written)}'


def _where_set(path: str, written: str) -> str:
    """Return the advice to write `written` behind the field's name where the program sets the field."""
    return f': where the program sets this field, write message.{path}{written}'


def _as_number(value: object, kind: type[int | float]) -> str:
    """Return advice such as ' (write 5)' for a text or a float that `kind` can convert; '' for any other
    value. A float with decimals was probably computed, so 'int(…)' is the advice.
    """
    if kind is int and isinstance(value, float) and not value.is_integer():
        return ' (write int(…))' if math.isfinite(value) else ''
    try:
        number = kind(value) if isinstance(value, str) else int(value) if isinstance(value, float) else None
    except (ValueError, OverflowError):
        return ''
    return '' if number is None else f' (write {number!r})'


def _as_bool(value: object) -> str:
    """Return what to write for a bool: 'True' or 'False' if the value is 1 or 0, else 'True or False'."""
    is_number = hasattr(value, '__index__') or type(value).__module__ == 'numpy'
    return str(bool(value == 1)) if is_number and value in {0, 1} else 'True or False'


def _judge_text(root: str, path: str, leaf: Leaf, value: object) -> None:
    if not isinstance(value, str):
        if isinstance(value, bytes | bytearray):
            raise EncodeTypeError(root, path, f'expected str, got {_show(value)} (write ….decode())')
        written = "''" if value is None else repr(str(value)) if isinstance(value, int | float) else 'str(…)'
        raise EncodeTypeError(root, path, f'expected str, got {_show(value)} (write {written})')
    try:
        data = value.encode()
    except UnicodeEncodeError as error:
        raise EncodeValueError(
            root, path, f'no valid Unicode at character {error.start}: {error.reason}'
        ) from None
    if leaf.type.base == 'string' and 0 in data:
        raise EncodeValueError(
            root, path, f'a string cannot contain a NUL (at character {value.index(chr(0))})'
        )
    size = len(data) if leaf.type.base == 'string' else len(value.encode('utf-16-le')) // 2
    if 0 < leaf.type.string_capacity < size:
        unit = 'bytes of UTF-8' if leaf.type.base == 'string' else 'UTF-16 units'
        raise EncodeValueError(root, path, f'expected at most {leaf.type.string_capacity} {unit}, got {size}')


def _judge_float(root: str, path: str, base: str, value: object) -> None:
    if not isinstance(value, float):
        number = hasattr(value, '__float__') and not isinstance(value, str)
        hint = f' (write {value!r}.0)' if type(value) is int else ' (write float(…))' if number else ''
        hint = hint or _as_number(value, float)
        raise EncodeTypeError(root, path, f'expected float, got {_show(value)}{hint}')
    if base == 'float32' and math.isfinite(value) and abs(value) >= _FLOAT32_LIMIT:
        raise EncodeValueError(root, path, f'{value!r} is outside the range of float32')


def _judge_integer(root: str, path: str, base: str, value: object) -> None:
    if not hasattr(value, '__index__'):
        hint = _as_number(value, int)
        raise EncodeTypeError(root, path, f'expected int, got {_show(value)}{hint}')
    low, high = integer_range(base)
    if not low <= value.__index__() <= high:
        hint = f'write a number from {low} to {high}, or take a type with a larger range'
        raise EncodeValueError(
            root, path, f'{value!r} is outside the range of {base}, [{low}, {high}] ({hint})'
        )


def _brief(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 30 else '…'


def _show(value: object) -> str:
    cls = type(value)
    if hasattr(cls, 'get_fields_and_field_types'):
        return type_name(cls)
    text = repr(value)
    name = cls.__name__ if cls.__module__ == 'builtins' else f'{cls.__module__}.{cls.__name__}'
    return f'{name} {text if len(text) <= 60 else text[:57] + "..."}'


def byte_order(cls: type, data: reading.Buffer) -> str:
    """Return the byte order in a message's header, '<' or '>'; raises DecodeError for a header that is not
    XCDR1's.
    """
    if len(data) < HEADER_SIZE:
        raise DecodeError(
            type_name(cls), '', len(data), f'the header has {HEADER_SIZE} bytes, the data {len(data)}'
        )
    kind = data[0] << 8 | data[1]
    if kind not in (_LITTLE_ENDIAN, _BIG_ENDIAN):
        names = {2: 'a parameter list', 3: 'a parameter list', **dict.fromkeys(range(6, 12), 'XCDR2')}
        what = names.get(kind, 'unknown')
        raise DecodeError(
            type_name(cls),
            '',
            0,
            f'representation {bytes(data[:2]).hex()} is {what}; ROS 2 messages are plain CDR (0000, 0001)',
        )
    return '<' if kind == _LITTLE_ENDIAN else '>'


def explain_decode(cls: type, data: reading.Buffer, error: Exception) -> DecodeError:
    """Return the error to raise for bytes that a decoder refused; the error keeps no reference to
    the bytes.
    """
    return _detach(_decode_error(cls, data, error))


def _detach(error: E) -> E:
    """Return an error without its frames and its context, which refer to the data that was read
    or written.
    """
    error.__context__ = None
    return error.with_traceback(None)


def _decode_error(cls: type, data: reading.Buffer, error: Exception) -> DecodeError:
    if isinstance(error, DecodeError):
        return error
    at = 0
    try:
        walk = _Walk(type_name(cls), data, byte_order(cls, data))
        walk.message(cls, '')
        at = walk.at
    except DecodeError as found:
        found.__context__ = None
        return found.with_traceback(None)
    except Exception as other:
        error = other
    return DecodeError(type_name(cls), '', at, f'cannot be decoded: {error!r}')


class _Walk:
    """Reads a message field by field, to find the first field that cannot be read."""

    def __init__(self, root: str, data: reading.Buffer, order: str) -> None:
        self.at = HEADER_SIZE
        self._root = root
        self._data = data
        self._order = order

    def fail(self, path: str, problem: str) -> None:
        raise DecodeError(self._root, path, self.at, problem)

    def message(self, cls: type, prefix: str) -> None:
        if not layout.leaves(cls):
            self._take(prefix.rstrip('.'), 1, 1)
        for leaf in layout.leaves(cls):
            self._leaf(leaf, prefix + leaf.name)

    def _leaf(self, leaf: Leaf, path: str) -> None:
        if leaf.type.shape is Shape.SINGLE:
            self._single(leaf, path)
            return
        count = leaf.type.capacity if leaf.type.shape is Shape.ARRAY else self._length(path)
        if leaf.type.shape is Shape.BOUNDED and count > leaf.type.capacity:
            self.fail(path, f'has {count} values, its type at most {leaf.type.capacity}')
        least = count * layout.element_minimum(leaf)
        if least > len(self._data) - self.at:
            self.fail(
                path,
                f'has {count} values of at least {least} bytes, but {len(self._data) - self.at} are left',
            )
        if leaf.type.is_number:
            if count:
                self._take(path, count * layout.SIZES[leaf.type.base], layout.SIZES[leaf.type.base])
            return
        for index in range(count):
            self._single(leaf, f'{path}[{index}]')

    def _single(self, leaf: Leaf, path: str) -> None:
        if leaf.cls is not None:
            self.message(leaf.cls, f'{path}.')
        elif leaf.type.is_string:
            self._text(leaf, path)
        else:
            size = layout.SIZES[leaf.type.base]
            start = self._take(path, size, size)
            if leaf.type.base == 'bool' and self._data[start] > 1:
                self.at = start
                self.fail(path, f'a bool is 0 or 1, not {self._data[start]}')

    def _text(self, leaf: Leaf, path: str) -> None:
        size = self._length(path)
        wide = leaf.type.base == 'wstring'
        limit = leaf.type.string_capacity
        if 0 < limit < size - (not wide):
            self.fail(
                path,
                f'has {size} {"units" if wide else "bytes with the NUL"}, its type at most {limit} without',
            )
        start = self._take(path, size * 4 if wide else size, 1)
        try:
            if wide:
                reading.wide_text(self._data, start, size, self._order)
            else:
                reading.text(self._data, start, size)
        except ValueError as error:
            self.at = start
            reason = error.reason if isinstance(error, UnicodeDecodeError) else str(error)
            self.fail(path, f'no valid {"UTF-16" if wide else "UTF-8"} ({reason})')

    def _length(self, path: str) -> int:
        start = self._take(path, 4, 4)
        (length,) = struct.unpack_from(f'{self._order}I', self._data, start)
        return int(length)

    def _take(self, path: str, size: int, alignment: int) -> int:
        """Skip the padding and `size` bytes, and return the position of these bytes."""
        start = self.at + -(self.at - HEADER_SIZE) % alignment
        if start + size > len(self._data):
            self.fail(path, f'needs {size} bytes, but the data ends at byte {len(self._data)}')
        self.at = start + size
        return start
