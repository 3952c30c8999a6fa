"""Encoding and decoding one value at a time: what is accepted, what is refused, and in which words."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
import pytest
from cdr import reference
from helpers.names import fresh_package

from goalwire.cdr import codec
from goalwire.errors import DecodeError, EncodeError, EncodeTypeError, EncodeValueError, UnknownInterfaceError
from goalwire.idl import get_message, register_definitions
from goalwire.idl.model import Shape
from goalwire.idl.registry import message_definition
from goalwire.payload_parts import Parts

PACKAGE = 'codec_test_msgs'  # in the names of tests, too: every worker of pytest gives the same ones
register_definitions(
    PACKAGE,
    {
        'msg/Point': 'float64 x',
        'msg/Twin': 'float64 x',
        'msg/Nothing': '',
        'msg/Demo': (
            'bool flag\nbyte octet\nchar letter\nint8 small\nint64 number\nuint64 big\nfloat32 f\nfloat64 d\n'
            'string text\nstring<=3 short\nwstring wide\nwstring<=3 tight\nPoint point\n'
            'int32[3] fixed\nbool[2] flags\nbyte[2] octets\nstring[2] texts\nPoint[2] pair\n'
            'float64[] reals\nint32[<=3] few\nbool[] many\nbyte[] raw\nstring[<=2] names\nPoint[<=2] points\n'
        ),
        'msg/Depth': 'sensor_msgs/Image image',
        'msg/Album': 'string title\nsensor_msgs/Image[] images',
        'msg/Chart': 'Point[] points\nsensor_msgs/Range[] ranges',
    },
)
Demo: Any = get_message(f'{PACKAGE}/msg/Demo')
Album: Any = get_message(f'{PACKAGE}/msg/Album')
Point: Any = get_message(f'{PACKAGE}/msg/Point')
Twin: Any = get_message(f'{PACKAGE}/msg/Twin')
String: Any = get_message('std_msgs/msg/String')


def demo(field: str, value: object) -> Any:
    """Return a message with one field set."""
    message = Demo()
    setattr(message, field, value)
    return message


@pytest.mark.parametrize(
    ('field', 'value', 'read'),
    [
        ('small', True, 1),
        ('number', np.int64(-4), -4),
        ('big', np.uint64(2**63), 2**63),
        ('letter', np.uint8(3), 3),
        ('d', np.float64(0.5), 0.5),
        ('d', float('inf'), float('inf')),
        ('f', 0.1, np.float32(0.1)),
        ('f', float('-inf'), float('-inf')),
        ('text', 'é', 'é'),
        ('short', 'abc', 'abc'),
        ('wide', '𝄞é\0', '𝄞é\0'),
        ('text', np.str_('numpy'), 'numpy'),
        ('flags', (True, False), [True, False]),
        ('many', np.array([True, False]), [True, False]),
        ('many', {True}, [True]),
        ('raw', b'ab', [b'a', b'b']),
        ('raw', [b'a'], [b'a']),
        ('octets', b'ab', [b'a', b'b']),
        ('names', ('a', 'b'), ['a', 'b']),
        ('texts', np.array(['x', 'y']), ['x', 'y']),
        ('points', (Point(x=1.0),), [Point(x=1.0)]),
        ('reals', array('d', [1.0]), array('d', [1.0])),
        ('few', [], array('i')),
    ],
)
def test_what_ros2_serialises_rightly_is_accepted(field: str, value: object, read: object) -> None:
    back = codec.decode(codec.encode(demo(field, value)), Demo)
    assert getattr(back, field) == read


@pytest.mark.parametrize(
    ('field', 'value', 'problem'),
    [
        ('flag', 1, 'expected bool, got int 1 (write True)'),
        ('flag', None, 'expected bool, got NoneType None (write True or False)'),
        ('octet', b'ab', "expected bytes of length 1, got bytes b'ab'"),
        ('octet', 1, 'expected bytes of length 1, got int 1'),
        ('octet', bytearray(b'a'), "expected bytes of length 1, got bytearray bytearray(b'a')"),
        ('small', 2.0, 'expected int, got float 2.0 (write 2)'),
        ('small', 3.99, 'expected int, got float 3.99 (write int(…))'),
        ('small', '1', "expected int, got str '1' (write 1)"),
        ('d', 1, 'expected float, got int 1 (write 1.0)'),
        ('d', True, 'expected float, got bool True (write float(…))'),
        ('d', None, 'expected float, got NoneType None'),
        ('f', 1, 'expected float, got int 1 (write 1.0)'),
        ('text', b'a', "expected str, got bytes b'a'"),
        ('wide', b'a', "expected str, got bytes b'a'"),
        ('point', None, 'expected Point, got NoneType None'),
        ('point', Twin(), f'expected Point, got {PACKAGE}/msg/Twin'),
        ('points', 5, 'expected a sequence, got int 5'),
        ('names', None, 'expected a sequence, got NoneType None'),
    ],
)
def test_a_wrong_type_is_refused(field: str, value: object, problem: str) -> None:
    with pytest.raises(EncodeTypeError) as caught:
        codec.encode(demo(field, value))
    assert str(caught.value).startswith(f'{PACKAGE}/msg/Demo: {field}: {problem}')
    assert isinstance(caught.value, TypeError)
    assert (caught.value.type_name, caught.value.field) == (f'{PACKAGE}/msg/Demo', field)


@pytest.mark.parametrize(
    ('field', 'value', 'problem'),
    [
        ('letter', 256, '256 is outside the range of char, [0, 255]'),
        ('small', -129, '-129 is outside the range of int8, [-128, 127]'),
        ('number', 2**63, 'is outside the range of int64'),
        ('big', -1, '-1 is outside the range of uint64'),
        ('f', 1e39, '1e+39 is outside the range of float32'),
        ('text', 'a\0b', 'a string cannot contain a NUL (at character 1)'),
        ('text', '\ud800', 'no valid Unicode at character 0: surrogates not allowed'),
        ('wide', '\ud800', 'no valid Unicode at character 0: surrogates not allowed'),
        ('short', 'four', 'expected at most 3 bytes of UTF-8, got 4'),
        ('short', 'éé', 'expected at most 3 bytes of UTF-8, got 4'),
        ('tight', '𝄞𝄞', 'expected at most 3 UTF-16 units, got 4'),
        ('fixed', [1, 2], 'expected exactly 3 values, got 2'),
        ('fixed', [1, 2, 3, 4], 'expected exactly 3 values, got 4'),
        ('flags', [True], 'expected exactly 2 values, got 1'),
        ('octets', b'abc', 'expected exactly 2 values, got 3'),
        ('texts', ['a'], 'expected exactly 2 values, got 1'),
        ('pair', [Point()], 'expected exactly 2 values, got 1'),
        ('few', [1, 2, 3, 4], 'expected at most 3 values, got 4'),
        ('names', ['a'] * 3, 'expected at most 2 values, got 3'),
        ('points', [Point()] * 3, 'expected at most 2 values, got 3'),
    ],
)
def test_a_value_that_does_not_fit_is_refused(field: str, value: object, problem: str) -> None:
    with pytest.raises(EncodeValueError) as caught:
        codec.encode(demo(field, value))
    assert problem in str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ('field', 'value', 'path'),
    [
        ('point', Point(x=1), 'point.x'),
        ('points', [Point(), Point(x=None)], 'points[1].x'),
        ('points', [Twin()], 'points[0]'),
        ('names', ['a', 1], 'names[1]'),
        ('many', [True, 1], 'many[1]'),
        ('raw', [b'a', b'bc'], 'raw[1]'),
        ('raw', [1], 'raw[0]'),
    ],
)
def test_a_wrong_value_inside_is_named_by_its_path(field: str, value: object, path: str) -> None:
    with pytest.raises(EncodeError) as caught:
        codec.encode(demo(field, value))
    assert caught.value.field == path


def test_an_array_that_was_changed_afterwards_is_looked_at_again() -> None:
    message = Demo()
    message.few.extend([1, 2, 3, 4])
    with pytest.raises(EncodeValueError, match='few: expected at most 3 values, got 4'):
        codec.encode(message)


def test_a_subclass_of_a_message_is_that_message() -> None:
    class MyPoint(Point):  # type: ignore[misc]
        __slots__ = ()

    assert codec.encode(demo('point', MyPoint(x=1.0))) == codec.encode(demo('point', Point(x=1.0)))


def test_an_encoder_refuses_other_messages() -> None:
    with pytest.raises(EncodeTypeError, match=r'Point: expected Point, got .*/msg/Twin'):
        codec.encoder(Point)(Twin())


@pytest.mark.parametrize('thing', [1, None, String, 'x'])
def test_what_is_no_message_has_no_encoder(thing: object) -> None:
    with pytest.raises(UnknownInterfaceError, match='is not a message, service or action class'):
        codec.encode(thing)


def test_a_service_has_no_bytes() -> None:
    from std_srvs.srv import SetBool

    with pytest.raises(TypeError, match='only messages have bytes'):
        codec.encoder(SetBool)


@pytest.mark.parametrize(
    ('data', 'offset', 'problem'),
    [
        (b'', 0, 'the header has 4 bytes, the data 0'),
        (b'\0\1', 2, 'the header has 4 bytes, the data 2'),
        (b'\0\1\0\0', 4, 'needs 4 bytes, but the data ends at byte 4'),
        (b'\0\1\0\0\3\0', 4, 'needs 4 bytes, but the data ends at byte 6'),
        (b'\0\1\0\0\xff\0\0\0ab\0', 8, 'needs 255 bytes, but the data ends at byte 11'),
        (b'\0\1\0\0\xff\xff\xff\xffab\0', 8, 'needs 4294967295 bytes'),
        (b'\0\1\0\0\2\0\0\0\xff\0', 8, 'no valid UTF-8 (invalid start byte)'),
        (b'\0\7\0\0\1\0\0\0\0', 0, 'representation 0007 is XCDR2'),
        (b'\0\3\0\0\1\0\0\0\0', 0, 'representation 0003 is a parameter list'),
        (b'\1\0\0\0\1\0\0\0\0', 0, 'representation 0100 is unknown'),
    ],
)
def test_malformed_bytes_are_refused_by_offset(data: bytes, offset: int, problem: str) -> None:
    for given in (data, bytearray(data), memoryview(data)):
        with pytest.raises(DecodeError) as caught:
            codec.decode(given, String)
        assert problem in str(caught.value)
        assert (caught.value.type_name, caught.value.offset) == ('std_msgs/msg/String', offset)


@pytest.mark.parametrize(
    ('data', 'expected'),
    [
        (b'\0\1\0\0\3\0\0\0ab\0', 'ab'),
        (b'\0\1\0\0\3\0\0\0ab\0' + bytes(7), 'ab'),  # padding
        (b'\0\1\0\0\3\0\0\0ab\0' + b'\xff' * 32, 'ab'),  # rmw_serialize gives more than it wrote
        (b'\0\1\0\2\3\0\0\0ab\0', 'ab'),  # options in the header are for XCDR2
        (b'\0\0\0\0\0\0\0\3ab\0', 'ab'),  # big endian
        (b'\0\1\0\0\2\0\0\0ab', 'ab'),  # no NUL, as Fast-CDR takes it
        (b'\0\1\0\0\0\0\0\0', ''),  # not even a NUL
        (b'\0\1\0\0\4\0\0\0a\0b\0', 'a\0b'),
    ],
)
def test_odd_but_readable_strings_are_read(data: bytes, expected: str) -> None:
    for given in (data, bytearray(data), memoryview(data), memoryview(b'x' + data)[1:]):
        assert codec.decode(given, String).data == expected


def test_a_text_is_no_data() -> None:
    with pytest.raises(TypeError, match='expected bytes, got str'):
        codec.decode('x', String)  # type: ignore[arg-type]


def test_a_bool_is_0_or_1() -> None:
    flag = get_message('std_msgs/msg/Bool')
    with pytest.raises(DecodeError, match='data: at byte 4: a bool is 0 or 1, not 2'):
        codec.decode(b'\0\1\0\0\2', flag)


def test_a_bool_in_a_sequence_is_0_or_1_and_named_by_its_index() -> None:
    parameter = get_message('rcl_interfaces/msg/ParameterValue')
    good = codec.encode(parameter(bool_array_value=[True, False, True]))
    at = good.index(b'\1\0\1', 40)
    bad = good[: at + 1] + b'\7' + good[at + 2 :]
    with pytest.raises(
        DecodeError, match=rf'bool_array_value\[1\]: at byte {at + 1}: a bool is 0 or 1, not 7'
    ):
        codec.decode(bad, parameter)


@pytest.mark.parametrize('count', [1, 1000, 2**31, 2**32 - 1])
@pytest.mark.parametrize(
    'type_name', ['geometry_msgs/msg/Polygon', 'std_msgs/msg/UInt8MultiArray', 'nav_msgs/msg/Path',
                  'sensor_msgs/msg/JointState']
)  # fmt: skip
def test_a_length_beyond_the_data_allocates_nothing(type_name: str, count: int) -> None:
    import tracemalloc

    cls = get_message(type_name)
    data = bytearray(codec.encode(cls()))
    data[-4:] = count.to_bytes(4, 'little')  # the last field of each is a sequence
    decode = codec.decoder(cls)
    with pytest.raises(DecodeError):
        decode(data)
    tracemalloc.start()
    try:
        with pytest.raises(DecodeError):
            decode(data)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


def test_empty_messages_in_a_sequence_are_bounded_by_their_byte() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Nothing': '', 'msg/Many': 'Nothing[] nothings'})
    many: Any = get_message(f'{package}/msg/Many')
    nothing: Any = get_message(f'{package}/msg/Nothing')
    assert codec.encode(many(nothings=[nothing()] * 3)) == b'\0\1\0\0\3\0\0\0\0\0\0'
    with pytest.raises(DecodeError, match='nothings: at byte 8: has 4000000000 values'):
        codec.decode(b'\0\1\0\0' + (4_000_000_000).to_bytes(4, 'little') + bytes(16), many)


@pytest.mark.parametrize('shape', ['[]', '[<=4]', '[3]'])
@pytest.mark.parametrize('before', ['', 'bool before\n', 'int16 before\n', 'string before\n'])
@pytest.mark.parametrize(
    'item',
    [
        'bool a\nint16 b',
        'int16 b\nbool a',
        'float64 a\nint32 b',
        'int32 b\nfloat64 a',
        'float32 a\nint8[4] b',
        '',
    ],
)
def test_messages_in_a_sequence_lie_as_their_values_do(item: str, before: str, shape: str) -> None:
    """CDR knows no alignment of messages, only of values."""
    package = fresh_package()
    register_definitions(package, {'msg/Item': item, 'msg/Many': f'{before}Item{shape} items'})
    many: Any = get_message(f'{package}/msg/Many')
    one: Any = get_message(f'{package}/msg/Item')
    fields = {field.name: field.type for field in message_definition(f'{package}/msg/Item').fields}
    zeros = {name: [0] * 4 if type_.shape is Shape.ARRAY else 0 for name, type_ in fields.items()}
    values = {'items': [zeros] * 3} | ({'before': '' if 'string' in before else 0} if before else {})
    message = many(items=[one() for _ in range(3)])
    for order in '<>':
        data = reference.encode(message_definition(f'{package}/msg/Many'), values, order)
        assert codec.decode(data, many) == message
    assert codec.encode(message) == reference.encode(message_definition(f'{package}/msg/Many'), values)


def test_an_empty_message_is_one_byte_and_read_without_it_too() -> None:
    empty: Any = get_message('std_msgs/msg/Empty')
    assert codec.encode(empty()) == b'\0\1\0\0\0'
    assert codec.decode(b'\0\1\0\0', empty) == empty()
    assert codec.decode(b'\0\0\0\0\0', empty) == empty()


def test_an_empty_sequence_of_doubles_has_no_padding() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Values': 'float64[] values'})
    values: Any = get_message(f'{package}/msg/Values')
    assert codec.encode(values()) == b'\0\1\0\0\0\0\0\0'
    assert len(codec.encode(values(values=[1.0]))) == 4 + 8 + 8


def test_a_large_array_is_read_from_a_view_without_an_extra_copy() -> None:
    import tracemalloc

    cls = get_message('std_msgs/msg/UInt8MultiArray')
    data = memoryview(bytearray(codec.encode(cls(data=bytes(4_000_000)))))
    codec.decode(data, cls)
    tracemalloc.start()
    try:
        message: Any = codec.decode(data, cls)
        assert tracemalloc.get_traced_memory()[1] < 4_400_000
    finally:
        tracemalloc.stop()
    assert len(message.data) == 4_000_000


def test_decoded_messages_are_as_good_as_new_ones() -> None:
    back = codec.decode(codec.encode(Demo()), Demo)
    assert back == Demo()
    back.few = [1]
    assert back.few == array('i', [1])
    back.fixed[0] = 7  # writable, and not a window into the bytes
    assert back.fixed.tolist() == [7, 0, 0]
    assert back.pair[0] is not back.pair[1]


@pytest.mark.parametrize('unit', [0x110000, 0x80000000, 0xFFFFFFFF, 0xD800])
def test_a_wide_string_holds_utf_16_units_or_code_points(unit: int) -> None:
    wide = get_message('example_interfaces/msg/WString')
    data = b'\0\1\0\0\1\0\0\0' + unit.to_bytes(4, 'little')
    with pytest.raises(DecodeError, match=r'data: at byte 8: no valid UTF-16'):
        codec.decode(data, wide)


def test_a_wide_string_of_code_points_is_read_too() -> None:
    wide: Any = get_message('example_interfaces/msg/WString')
    assert codec.decode(b'\0\1\0\0\1\0\0\0' + ord('𝄞').to_bytes(4, 'little'), wide).data == '𝄞'


@pytest.mark.parametrize(
    ('values', 'is_large'),
    [
        ({'reals': array('d', [0.5]), 'raw': [b'a'], 'text': 'é', 'names': ['left']}, False),
        ({'reals': array('d', bytes(80_000)), 'points': [Point(x=1.0)], 'wide': 'é'}, True),
        ({'reals': memoryview(array('d', bytes(80_000))), 'few': [1, 2, 3]}, True),
        ({'raw': [b'a'] * 70_000, 'many': [True] * 3}, True),
    ],
)
def test_a_large_message_for_the_wire_is_not_joined(values: dict[str, Any], is_large: bool) -> None:
    message = Demo()
    for name, value in values.items():
        setattr(message, f'_{name}', value)
    payload = codec.payload_encoder(Demo)(message)
    whole = b''.join(codec.parts_encoder(Demo)(message))
    assert len(payload) == len(whole)
    assert bytes(payload) == whole
    assert isinstance(payload, Parts) == is_large


def test_the_classes_with_numbers_are_those_that_may_be_large() -> None:
    assert codec.has_numbers(Demo)
    assert not codec.has_numbers(String)
    assert not codec.has_numbers(get_message(f'{PACKAGE}/msg/Chart'))


def test_a_class_has_the_numbers_of_the_messages_inside_it() -> None:
    assert codec.has_numbers(get_message(f'{PACKAGE}/msg/Depth'))
    assert codec.has_numbers(Album)


@pytest.mark.parametrize(('size', 'count', 'is_large'), [(100_000, 2, True), (100, 2000, False)])
def test_a_large_message_of_many_small_buffers_is_joined(size: int, count: int, is_large: bool) -> None:
    image = get_message('sensor_msgs/msg/Image')
    message = Album(title='é', images=[image(encoding='mono8', data=array('B', bytes(size)))] * count)
    payload = codec.payload_encoder(Album)(message)
    assert bytes(payload) == codec.encode(message)
    assert isinstance(payload, Parts) == is_large
