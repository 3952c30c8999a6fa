"""The two descriptions of a field's type, there and back."""

from __future__ import annotations

from typing import Any

import pytest
from rosidl_parser import definition as idl

from goalwire.idl import get_message
from goalwire.idl.model import FieldType, Shape
from goalwire.idl.slot_types import from_slot_type, to_slot_type, type_text

POINT = 'geometry_msgs/msg/Point'

CASES = [
    (FieldType('bool'), 'boolean', idl.BasicType('boolean')),
    (FieldType('byte'), 'octet', idl.BasicType('octet')),
    (FieldType('float32'), 'float', idl.BasicType('float')),
    (FieldType('float64', Shape.ARRAY, 36), 'double[36]', idl.Array(idl.BasicType('double'), 36)),
    (FieldType('int8', Shape.UNBOUNDED), 'sequence<int8>', idl.UnboundedSequence(idl.BasicType('int8'))),
    (
        FieldType('uint64', Shape.BOUNDED, 3),
        'sequence<uint64, 3>',
        idl.BoundedSequence(idl.BasicType('uint64'), 3),
    ),
    (FieldType('string'), 'string', idl.UnboundedString()),
    (FieldType('string', string_capacity=22), 'string<22>', idl.BoundedString(22)),
    (FieldType('wstring'), 'wstring', idl.UnboundedWString()),
    (FieldType('wstring', string_capacity=5), 'wstring<5>', idl.BoundedWString(5)),
    (
        FieldType('string', Shape.BOUNDED, 3, 22),
        'sequence<string<22>, 3>',
        idl.BoundedSequence(idl.BoundedString(22), 3),
    ),
    (FieldType(POINT), 'geometry_msgs/Point', idl.NamespacedType(['geometry_msgs', 'msg'], 'Point')),
    (
        FieldType(POINT, Shape.UNBOUNDED),
        'sequence<geometry_msgs/Point>',
        idl.UnboundedSequence(idl.NamespacedType(['geometry_msgs', 'msg'], 'Point')),
    ),
]


@pytest.mark.parametrize(('type_', 'text', 'slot'), CASES)
def test_a_type_is_described_as_rosidl_does(type_: FieldType, text: str, slot: idl.AbstractType) -> None:
    assert type_text(type_) == text
    assert to_slot_type(type_) == slot
    assert from_slot_type(slot) == type_


def test_char_is_an_uint8_in_both() -> None:
    assert type_text(FieldType('char')) == 'uint8'
    assert to_slot_type(FieldType('char')) == idl.BasicType('uint8')


def test_slot_types_of_a_class_are_made_once_and_seen_from_messages() -> None:
    cls: Any = get_message('geometry_msgs/msg/PoseWithCovariance')
    assert cls.SLOT_TYPES is cls().SLOT_TYPES
    pose, covariance = cls.SLOT_TYPES
    assert pose.namespaced_name() == ('geometry_msgs', 'msg', 'Pose')
    assert (covariance.size, covariance.value_type.typename) == (36, 'double')


def test_rosidls_types_compare_by_class_and_attributes() -> None:
    assert idl.UnboundedString() != idl.UnboundedWString()
    assert idl.BoundedString(1) != idl.BoundedString(2)
    assert idl.Array(idl.BasicType('int8'), 3) != idl.BoundedSequence(idl.BasicType('int8'), 3)
    assert len({idl.BasicType('int8'), idl.BasicType('int8')}) == 1
    assert idl.BoundedString(1).has_maximum_size()
    assert not idl.UnboundedSequence(idl.BasicType('int8')).has_maximum_size()


def test_what_is_no_basic_type_is_refused() -> None:
    with pytest.raises(AssertionError, match="'float64' is not a basic type"):
        idl.BasicType('float64')
