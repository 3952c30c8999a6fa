"""The type that a value has, and what a parameter may hold."""

from __future__ import annotations

from array import array
from typing import Any

import pytest

from goalwire.rules.parameters import Parameter, Type


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        (1, Type.INTEGER),
        (True, Type.BOOL),
        (1.0, Type.DOUBLE),
        ('s', Type.STRING),
        (None, Type.NOT_SET),
        ([], Type.BYTE_ARRAY),
        ([b'a'], Type.BYTE_ARRAY),
        ([True], Type.BOOL_ARRAY),
        ([1, 2], Type.INTEGER_ARRAY),
        ((1, 2), Type.INTEGER_ARRAY),
        ([1.0], Type.DOUBLE_ARRAY),
        (array('d', [1.0]), Type.DOUBLE_ARRAY),
        (['x'], Type.STRING_ARRAY),
    ],
    ids=repr,
)
def test_the_type_is_the_value_s(value: Any, expected: Type) -> None:
    assert Parameter('a', value=value).type_ is expected


def test_numpy_s_float_is_a_float_and_its_integer_is_none() -> None:
    numpy = pytest.importorskip('numpy')
    assert Parameter('a', value=numpy.float64(1)).type_ is Type.DOUBLE
    with pytest.raises(TypeError, match=r"^The given value is not one of the allowed types '1'\.\n"):
        Parameter('a', value=numpy.int64(1))
    with pytest.raises(TypeError, match=r"^The given value is not one of the allowed types '\[1\.\]'\.\n"):
        Parameter('a', value=numpy.array([1.0]))


@pytest.mark.parametrize(
    ('value', 'text'),
    [
        (b'ab', "The given value is not one of the allowed types 'b'ab''."),
        ({}, "The given value is not one of the allowed types '{}'."),
        ([1, 2.0], "The given value is not a list of one of the allowed types '[1, 2.0]'."),
        ([1, True], "The given value is not a list of one of the allowed types '[1, True]'."),
    ],
)
def test_what_no_parameter_holds_is_refused(value: Any, text: str) -> None:
    with pytest.raises(TypeError) as raised:
        Parameter('a', value=value)
    assert str(raised.value) == text


@pytest.mark.parametrize(
    ('type_', 'value'),
    [
        (Type.INTEGER, None),
        (Type.INTEGER, 'x'),
        (Type.INTEGER, 1.0),
        (Type.DOUBLE, 1),
        (Type.INTEGER, 2**63),
        (Type.INTEGER_ARRAY, [-(2**63) - 1]),
        (Type.INTEGER_ARRAY, array('Q', [2**63])),
        (Type.BYTE_ARRAY, [b'ab']),
        (Type.BYTE_ARRAY, [b'']),
    ],
    ids=repr,
)
def test_type_and_value_must_agree(type_: Type, value: Any) -> None:
    with pytest.raises(ValueError) as raised:
        Parameter('a', type_, value)
    assert str(raised.value) == f"Type '{type_}' and value '{value}' do not agree"


@pytest.mark.parametrize('type_', [2, 'x'])
def test_a_type_is_a_type(type_: Any) -> None:
    with pytest.raises(TypeError, match=r"^type must be an instance of '<enum 'Type'>'$"):
        Parameter('a', type_, 3)


def test_parameters_are_compared_by_identity_and_do_not_change() -> None:
    parameter = Parameter('a', value=1)
    assert parameter != Parameter('a', value=1)
    with pytest.raises(AttributeError, match="property 'value' of 'Parameter' object has no setter"):
        parameter.value = 2  # type: ignore[misc]


@pytest.mark.parametrize('value', [True, 1, 1.5, 's', [b'x'], [True], ['x'], None], ids=repr)
def test_a_parameter_survives_being_a_message(value: Any) -> None:
    again = Parameter.from_parameter_msg(Parameter('a', value=value).to_parameter_msg())
    assert (again.name, again.type_, again.value) == ('a', Type.from_parameter_value(value), value)


def test_numbers_come_out_of_a_message_as_arrays() -> None:
    def through(value: Any) -> object:
        return Parameter.from_parameter_msg(Parameter('a', value=value).to_parameter_msg()).value

    assert through([1.5]) == array('d', [1.5])
    assert through([1]) == array('q', [1])


def test_a_message_of_an_unknown_type_is_told_with_its_name() -> None:
    from rcl_interfaces.msg import Parameter as Message
    from rcl_interfaces.msg import ParameterValue

    with pytest.raises(ValueError, match=r"^parameter 'a': 99 is not a valid Parameter\.Type$"):
        Parameter.from_parameter_msg(Message(name='a', value=ParameterValue(type=99)))


def test_annotations_may_name_the_type_of_the_value() -> None:
    annotation: Any = Parameter
    assert annotation[str].__origin__ is Parameter
    assert annotation[str]('name', value='x').value == 'x'
