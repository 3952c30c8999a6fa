"""A slow CDR codec, written by hand and by the book: the oracle for the generated one.

It knows definitions, not classes: a message is a dict of its fields.
"""

from __future__ import annotations

import struct
from typing import Any

from goalwire.idl.model import FieldType, MessageDefinition, Shape
from goalwire.idl.registry import message_definition

_NUMBERS = {
    'bool': ('B', 1), 'char': ('B', 1), 'int8': ('b', 1), 'uint8': ('B', 1),
    'int16': ('h', 2), 'uint16': ('H', 2),
    'int32': ('i', 4), 'uint32': ('I', 4),
    'int64': ('q', 8), 'uint64': ('Q', 8), 'float32': ('f', 4),
    'float64': ('d', 8),
}  # fmt: skip


def encode(definition: MessageDefinition, value: dict[str, Any], order: str = '<') -> bytes:
    """Return the bytes of a message, header included."""
    writer = _Writer(order)
    writer.message(definition, value)
    return (b'\0\1\0\0' if order == '<' else b'\0\0\0\0') + bytes(writer.out)


def decode(definition: MessageDefinition, data: bytes) -> dict[str, Any]:
    """Return the fields of a message; any malformed data may raise anything."""
    order = {b'\0\0': '>', b'\0\1': '<'}[data[:2]]
    return _Reader(data[4:], order).message(definition)


class _Writer:
    def __init__(self, order: str) -> None:
        self.out = bytearray()
        self._order = order

    def message(self, definition: MessageDefinition, value: dict[str, Any]) -> None:
        if not definition.fields:
            self.out.append(0)
        for field in definition.fields:
            self._field(field.type, value[field.name])

    def _field(self, type_: FieldType, value: Any) -> None:
        if type_.shape is Shape.SINGLE:
            self._single(type_, value)
            return
        if type_.shape is not Shape.ARRAY:
            self._number('uint32', len(value))
        for item in value:
            self._single(type_, item)

    def _single(self, type_: FieldType, value: Any) -> None:
        if type_.is_message:
            self.message(message_definition(type_.base), value)
        elif type_.base == 'string':
            data = value.encode('utf-8') + b'\0'
            self._number('uint32', len(data))
            self.out += data
        elif type_.base == 'wstring':
            units = value.encode('utf-16-be')
            self._number('uint32', len(units) // 2)
            for high, low in zip(units[::2], units[1::2], strict=True):
                self._number('uint32', high * 256 + low)
        elif type_.base == 'byte':
            self.out += value
        else:
            self._number(type_.base, value)

    def _number(self, base: str, value: Any) -> None:
        code, size = _NUMBERS[base]
        while len(self.out) % size:
            self.out.append(0)
        self.out += struct.pack(self._order + code, value)


class _Reader:
    def __init__(self, data: bytes, order: str) -> None:
        self._data = data
        self._order = order
        self._at = 0

    def message(self, definition: MessageDefinition) -> dict[str, Any]:
        if not definition.fields:
            self._number('uint8')
        return {field.name: self._field(field.type) for field in definition.fields}

    def _field(self, type_: FieldType) -> Any:
        if type_.shape is Shape.SINGLE:
            return self._single(type_)
        count = type_.capacity if type_.shape is Shape.ARRAY else self._number('uint32')
        return [self._single(type_) for _ in range(count)]

    def _single(self, type_: FieldType) -> Any:
        if type_.is_message:
            return self.message(message_definition(type_.base))
        if type_.base == 'string':
            size = self._number('uint32')
            data = self._data[self._at : self._at + size]
            self._at += size
            return data[:-1].decode('utf-8')
        if type_.base == 'wstring':
            units = [self._number('uint32') for _ in range(self._number('uint32'))]
            return b''.join(unit.to_bytes(2, 'big') for unit in units).decode('utf-16-be')
        if type_.base == 'byte':
            return bytes((self._number('uint8'),))
        return bool(self._number('bool')) if type_.base == 'bool' else self._number(type_.base)

    def _number(self, base: str) -> Any:
        code, size = _NUMBERS[base]
        self._at += -self._at % size
        (value,) = struct.unpack_from(self._order + code, self._data, self._at)
        self._at += size
        return value
