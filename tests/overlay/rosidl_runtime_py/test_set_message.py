"""Messages filled from dictionaries."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point32, Polygon, PoseStamped, PoseWithCovariance, Twist, Vector3
from rosidl_runtime_py import set_message_fields
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Byte, Char, Header, Int32, Int32MultiArray, String, UInt8MultiArray


def filled(cls: Any, values: Any) -> Any:
    message = cls()
    assert set_message_fields(message, values) == []
    return message


@pytest.mark.parametrize(
    ('values', 'x'),
    [({'linear': {'x': 1.5}}, 1.5), ({'linear': {'x': 1}}, 1.0), ({'linear': {'x': '2.5'}}, 2.5)],
)
def test_numbers_are_converted_to_the_type_of_their_field(values: object, x: float) -> None:
    message = filled(Twist, values)
    assert message == Twist(linear=Vector3(x=x))
    assert type(message.linear.x) is float


@pytest.mark.parametrize(
    ('cls', 'given', 'stored'),
    [
        (String, 5, '5'),
        (String, True, 'True'),
        (Int32, '7', 7),
        (Int32, 1.7, 1),
        (Int32, 2**31, 2**31),
        (Bool, 'false', True),
        (Bool, 0, False),
        (Byte, b'a', b'a'),
        (Char, 65, 65),
    ],
)
def test_a_value_is_converted_as_its_type_converts(cls: Any, given: object, stored: object) -> None:
    data = filled(cls, {'data': given}).data
    assert data == stored
    assert type(data) is type(stored)


def test_a_number_for_a_byte_is_that_byte() -> None:
    assert filled(Byte, {'data': 5}).data == b'\x05'
    assert filled(DiagnosticStatus, {'level': 1}).level == DiagnosticStatus.WARN


@pytest.mark.parametrize(
    ('cls', 'values', 'error', 'text'),
    [
        (Twist, {'nope': 1}, AttributeError, "'Twist' object has no attribute 'nope'"),
        (Twist, {'linear': {'nope': 1}}, AttributeError, "'Vector3' object has no attribute 'nope'"),
        (Twist, {'linear': 5}, TypeError, "Value '5' is expected to be a dictionary but is a int"),
        (Twist, 'x', TypeError, "Value 'x' is expected to be a dictionary but is a str"),
        (Twist, None, TypeError, "Value 'None' is expected to be a dictionary but is a NoneType"),
        (Polygon, {'points': {'x': 1.0}}, TypeError, "Value 'x' is expected to be a dictionary but is a str"),
        (PoseStamped, {'header': 'auto'}, TypeError, "Value 'auto' is expected to be a dictionary"),
        (PoseStamped, {'header': {'stamp': 'now'}}, TypeError, "Value 'now' is expected to be a dictionary"),
        (Int32, {'data': 'x'}, ValueError, "invalid literal for int() with base 10: 'x'"),
        (
            Int32MultiArray,
            {'data': ['1', 2.0]},
            TypeError,
            "'str' object cannot be interpreted as an integer",
        ),
        (Byte, {'data': 256}, ValueError, 'range(0, 256)'),
    ],
)
def test_what_does_not_fit_is_an_error(cls: Any, values: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error) as caught:
        filled(cls, values)
    assert text in str(caught.value)


def test_arrays_keep_their_kind() -> None:
    assert filled(Int32MultiArray, {'data': [1, 2]}) == Int32MultiArray(data=[1, 2])
    assert filled(UInt8MultiArray, {'data': [1, 2]}) == UInt8MultiArray(data=[1, 2])
    assert filled(JointState, {'name': 'ab'}).name == ['a', 'b']
    covariance = filled(PoseWithCovariance, {'covariance': range(36)}).covariance
    assert covariance.dtype == np.float64
    assert covariance.tolist() == list(range(36))


def test_messages_in_an_array_are_made_of_dictionaries_and_the_callers_data_is_left_alone() -> None:
    values = {'points': [{'x': 1.0}, Point32(y=2.0)]}
    for _ in range(2):
        assert filled(Polygon, values).points == [Point32(x=1.0), Point32(y=2.0)]
    assert values['points'][0] == {'x': 1.0}


def test_nothing_changes_without_values() -> None:
    assert filled(Twist, {}) == Twist()


def test_a_header_given_as_auto_gets_its_stamp_later() -> None:
    message = PoseStamped()
    (set_stamp,) = set_message_fields(message, {'header': 'auto'}, expand_header_auto=True)
    set_stamp(Time(sec=7))
    assert message.header.stamp == Time(sec=7)


def test_a_time_given_as_now_gets_its_value_later() -> None:
    message = Header()
    (set_stamp,) = set_message_fields(message, {'frame_id': 'a', 'stamp': 'now'}, expand_time_now=True)
    set_stamp(Time(sec=7))
    assert message == Header(stamp=Time(sec=7), frame_id='a')


def test_a_nested_time_given_as_now_is_found() -> None:
    message = PoseStamped()
    (set_stamp,) = set_message_fields(message, {'header': {'stamp': 'now'}}, expand_time_now=True)
    set_stamp(Time(sec=7))
    assert message.header.stamp == Time(sec=7)
