"""With check_fields=True the setters refuse what rosidl's refuse, in rosidl's words."""

from __future__ import annotations

import subprocess
import sys
from array import array
from typing import Any

import numpy as np
import pytest
from helpers.names import fresh_package

from goalwire.idl import register_definitions
from goalwire.idl.classes import message_class


@pytest.fixture(scope='module')
def cls() -> Any:
    package = fresh_package()
    register_definitions(
        package,
        {
            'msg/Point': 'float64 x',
            'msg/Demo': (
                'bool flag\nbyte octet\nchar letter\nint8 small\nuint64 big\nfloat32 f\nfloat64 d\n'
                'string text\n'
                'string<=3 short\nPoint point\nint32[3] fixed\nbool[2] flags\nint32[] ints\nfloat32[] reals\n'
                'uint8[<=3] few\nstring[<=2] names\nbyte[] octets\nPoint[] points\nstring<=2[] words\n'
            ),
        },
    )
    return message_class(f'{package}/msg/Demo')


BOUND = '340282346600000016151267322115014000640.000000'
ANY = 'a set or sequence'
INT32 = "and each value of type 'int' and each integer in [-2147483648, 2147483647]"
UINT8 = "and each value of type 'int' and each unsigned integer in [0, 255]"
FLOAT32 = f"and each value of type 'float' and each float in [-{BOUND}, {BOUND}]"


@pytest.mark.parametrize(
    ('field', 'value', 'rest'),
    [
        ('flag', 1, "of type 'bool'"),
        ('octet', b'ab', "of type 'bytes' or 'ByteString' with length 1"),
        ('octet', 1, "of type 'bytes' or 'ByteString' with length 1"),
        ('letter', 'a', "of type 'int'"),
        ('letter', 256, 'an unsigned integer in [0, 255]'),
        ('small', 1.0, "of type 'int'"),
        ('small', np.int8(1), "of type 'int'"),
        ('small', 128, 'an integer in [-128, 127]'),
        ('big', -1, 'an unsigned integer in [0, 18446744073709551615]'),
        ('f', 1, "of type 'float'"),
        ('f', 3.5e38, 'a float in [-3.402823466e+38, 3.402823466e+38]'),
        ('text', None, "of type 'str'"),
        ('short', 'four', 'string value not longer than 3'),
        ('point', None, "a sub message of type 'Point'"),
        ('ints', 5, f'{ANY} {INT32}'),
        ('ints', [2**31], f'{ANY} {INT32}'),
        ('ints', np.array([1], np.int32), f'{ANY} {INT32}'),
        ('reals', [1], f'{ANY} {FLOAT32}'),
        ('few', [1, 2, 3, 4], f'{ANY} with length <= 3 {UINT8}'),
        ('fixed', [1, 2], f'{ANY} with length 3 {INT32}'),
        ('flags', [True], "a set or sequence with length 2 and each value of type 'bool'"),
        ('names', ['a'] * 3, "a set or sequence with length <= 2 and each value of type 'str'"),
        ('names', 'ab', "a set or sequence with length <= 2 and each value of type 'str'"),
        ('octets', b'ab', "a set or sequence and each value of type 'bytes'"),
        ('points', [1], "a set or sequence and each value of type 'Point'"),
        ('words', ['abc'], f"{ANY} and each string value not longer than 2 and each value of type 'str'"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_refused_in_rosidls_words(cls: Any, field: str, value: object, rest: str) -> None:
    message = cls(check_fields=True)
    with pytest.raises(AssertionError) as caught:
        setattr(message, field, value)
    assert str(caught.value) == f"The '{field}' field must be {rest}"


@pytest.mark.parametrize(
    ('field', 'value'),
    [('text', None), ('point', None), ('fixed', [1, 2]), ('octets', b'ab'), ('few', [1, 2, 3, 4])],
)
def test_a_wrong_value_is_refused_by_the_constructor_too(cls: Any, field: str, value: object) -> None:
    with pytest.raises(AssertionError, match=f"The '{field}' "):
        cls(check_fields=True, **{field: value})


def test_the_constructor_makes_sequences_of_numbers_before_they_are_checked(cls: Any) -> None:
    assert cls(check_fields=True, reals=[1]).reals == array('f', [1.0])
    with pytest.raises(OverflowError):
        cls(check_fields=True, ints=[2**31])


@pytest.mark.parametrize(
    ('field', 'value', 'text'),
    [
        ('ints', array('q', [1]), "The 'ints' array.array() must have the type code of 'i'"),
        ('few', array('B', [1] * 4), "The 'few' array.array() must have a size <= 3"),
        ('fixed', np.zeros(3), "The 'fixed' numpy.ndarray() must have the dtype of 'numpy.int32'"),
        ('fixed', np.zeros(2, np.int32), "The 'fixed' numpy.ndarray() must have a size of 3"),
    ],
)
def test_a_wrong_array_is_refused_in_rosidls_words(cls: Any, field: str, value: object, text: str) -> None:
    with pytest.raises(AssertionError) as caught:
        setattr(cls(check_fields=True), field, value)
    assert str(caught.value) == text


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('octet', bytearray(b'a')), ('letter', True), ('f', float('inf')), ('f', float('nan')),
        ('d', np.float64(1)),
        ('text', 'a\0b'), ('names', ('a',)), ('names', {'a'}), ('points', []), ('flags', [True, False]),
    ],
)  # fmt: skip
def test_a_right_value_is_stored_as_it_is(cls: Any, field: str, value: object) -> None:
    message = cls(check_fields=True)
    setattr(message, field, value)
    assert getattr(message, field) is value


def test_arrays_of_the_right_kind_are_stored_and_not_copied(cls: Any) -> None:
    ints, fixed = array('i', [1]), np.zeros(3, np.int32)
    message = cls(check_fields=True, fixed=fixed)
    message.ints = ints
    assert message.ints is ints
    assert message.fixed is fixed


def test_unknown_keywords_are_refused(cls: Any) -> None:
    with pytest.raises(AssertionError, match='Invalid arguments passed to constructor: _text, foo'):
        cls(foo=1, _text='x', check_fields=True)


def test_the_environment_variable_turns_checks_on() -> None:
    program = (
        'from goalwire.idl import get_message\n'
        "cls = get_message('std_msgs/msg/String')\n"
        'try:\n    cls().data = 1\n'
        'except AssertionError as error:\n    print(error)\n'
        'print(repr(cls(data=1, check_fields=False).data))\n'
    )
    result = subprocess.run(
        [sys.executable, '-c', program],
        env={'ROS_PYTHON_CHECK_FIELDS': '1'}, capture_output=True, text=True, timeout=30, check=False,
    )  # fmt: skip
    assert (result.stdout, result.stderr) == ("The 'data' field must be of type 'str'\n1\n", '')
