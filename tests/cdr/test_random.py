"""Random definitions, random values, random damage: the generated codec against the reference."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from cdr import reference
from helpers.names import fresh_package
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.cdr import codec, layout
from goalwire.errors import DecodeError
from goalwire.idl import get_message, register_definitions
from goalwire.idl.model import FLOATS, FieldType, Shape, integer_range
from goalwire.idl.registry import message_definition

PRIMITIVES = [
    'bool', 'byte', 'char', 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64', 'uint64',
    'float32', 'float64', 'string', 'wstring', 'string<=5', 'wstring<=5',
]  # fmt: skip
VARIED = ['sensor_msgs/msg/PointCloud2', 'rcl_interfaces/msg/ParameterEvent', 'visualization_msgs/msg/Marker']
SHAPES = ['', '[]', '[1]', '[3]', '[<=3]']
text = st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'), max_size=8)


@st.composite
def definitions(draw: st.DrawFn) -> dict[str, str]:
    """Draw a few messages; each may hold those before it."""
    messages: dict[str, str] = {}
    for number in range(draw(st.integers(1, 3))):
        bases = PRIMITIVES + [f'M{earlier}' for earlier in range(number)] * 4
        fields = draw(st.lists(st.tuples(st.sampled_from(bases), st.sampled_from(SHAPES)), max_size=6))
        lines = (f'{base}{shape} f{index}' for index, (base, shape) in enumerate(fields))
        messages[f'msg/M{number}'] = '\n'.join(lines)
    return messages


def single(draw: st.DrawFn, type_: FieldType) -> Any:
    if type_.is_message:
        return {field.name: value(draw, field.type) for field in message_definition(type_.base).fields}
    if type_.is_string:
        drawn = draw(text)
        size = type_.string_capacity
        return drawn[: size // 4 if type_.base == 'string' else size // 2] if size else drawn
    if type_.base == 'bool':
        return draw(st.booleans())
    if type_.base == 'byte':
        return draw(st.binary(min_size=1, max_size=1))
    if type_.base in FLOATS:
        return draw(st.floats(width=32 if type_.base == 'float32' else 64, allow_nan=False))
    return draw(st.integers(*integer_range(type_.base)))


def value(draw: st.DrawFn, type_: FieldType) -> Any:
    if type_.shape is Shape.SINGLE:
        return single(draw, type_)
    size = type_.capacity if type_.shape is Shape.ARRAY else draw(st.integers(0, 3))
    return [single(draw, type_) for _ in range(size)]


@st.composite
def messages(draw: st.DrawFn) -> tuple[type, dict[str, Any]]:
    """Draw a message class and the values of its fields."""
    package = fresh_package()
    texts = draw(definitions())
    register_definitions(package, texts)
    full_name = f'{package}/{max(texts)}'
    return get_message(full_name), single(draw, FieldType(full_name))


def build(cls: type, fields: dict[str, Any]) -> Any:
    message = cls()
    for leaf in layout.leaves(cls):
        given_value = fields[leaf.name]
        nested = leaf.cls
        if nested is not None and leaf.type.shape is Shape.SINGLE:
            given_value = build(nested, given_value)
        elif nested is not None:
            given_value = [build(nested, item) for item in given_value]
        setattr(message, leaf.name, given_value)
    return message


def definition_of(cls: type) -> Any:
    return message_definition('/'.join((cls.__module__.split('.')[0], 'msg', cls.__name__)))


@settings(max_examples=100, deadline=None)
@given(messages())
def test_bytes_are_those_of_the_reference(drawn: tuple[type, dict[str, Any]]) -> None:
    cls, fields = drawn
    message = build(cls, fields)
    data = codec.encode(message)
    assert data == reference.encode(definition_of(cls), fields)
    assert reference.decode(definition_of(cls), data) == fields
    assert codec.decode(data, cls) == message
    assert codec.decode(bytearray(data), cls) == message
    assert codec.decode(reference.encode(definition_of(cls), fields, '>'), cls) == message
    assert codec.decode(memoryview(reference.encode(definition_of(cls), fields, '>')), cls) == message


@settings(max_examples=60, deadline=None)
@given(messages())
def test_every_truncation_is_refused_or_only_padding(drawn: tuple[type, dict[str, Any]]) -> None:
    cls, fields = drawn
    data = codec.encode(build(cls, fields))
    shortest = len(data) if layout.leaves(cls) else 4
    for size in range(shortest):
        with pytest.raises(DecodeError) as caught:
            codec.decode(data[:size], cls)
        assert caught.value.offset <= size


def accepted_or_explained(data: bytes, cls: type) -> bool:
    """Tell whether data are read, or refused with the field and an offset inside them."""
    try:
        message: object = codec.decode(data, cls)
    except DecodeError as error:
        return error.offset <= len(data) and 'cannot be decoded' not in str(error)
    return isinstance(message, cls)


@settings(max_examples=150, deadline=None)
@given(messages(), st.data())
def test_damaged_bytes_give_a_message_or_a_decode_error(
    drawn: tuple[type, dict[str, Any]], data: st.DataObject
) -> None:
    cls, fields = drawn
    damaged = bytearray(codec.encode(build(cls, fields)))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at] = data.draw(st.sampled_from([0, 1, 2, 0x7F, 0x80, 0xFF]))
    assert accepted_or_explained(bytes(damaged), cls)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200), st.sampled_from(VARIED))
def test_noise_gives_a_message_or_a_decode_error(noise: bytes, type_name: str) -> None:
    cls = get_message(type_name)
    for header in (b'\0\1\0\0', b'\0\0\0\0'):
        assert accepted_or_explained(header + noise, cls)


def test_the_reference_knows_a_message_by_heart() -> None:
    """The oracle itself, against bytes worked out by hand."""
    package = fresh_package()
    register_definitions(package, {'msg/M': 'uint8 a\nfloat64 b\nstring c\nint16[] d'})
    fields = {'a': 1, 'b': 2.0, 'c': 'x', 'd': [3]}
    by_hand = b'\0\1\0\0\1' + bytes(7) + struct.pack('<d', 2.0) + b'\2\0\0\0x\0' + bytes(2) + b'\1\0\0\0\3\0'
    assert reference.encode(message_definition(f'{package}/msg/M'), fields) == by_hand
