"""Messages as dictionaries, YAML and CSV, in ROS 2's own forms."""

from __future__ import annotations

import subprocess
import sys
from collections import OrderedDict

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovariance, Twist, Vector3
from rosidl_runtime_py import message_to_csv, message_to_ordereddict, message_to_yaml
from rosidl_runtime_py.convert import Message, get_message_slot_types
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Bool, Empty, Float32, Float64, Float64MultiArray, Header, String, UInt8MultiArray


@pytest.mark.parametrize(
    ('message', 'text'),
    [
        (
            Twist(linear=Vector3(x=1.5)),
            'linear:\n  x: 1.5\n  y: 0.0\n  z: 0.0\nangular:\n  x: 0.0\n  y: 0.0\n  z: 0.0\n',
        ),
        (Header(frame_id='a'), 'stamp:\n  sec: 0\n  nanosec: 0\nframe_id: a\n'),
        (UInt8MultiArray(data=b'ab'), 'layout:\n  dim: []\n  data_offset: 0\ndata:\n- 97\n- 98\n'),
        (Bool(data=True), 'data: true\n'),
        (Float32(data=0.1), 'data: 0.1\n'),
        (Float64(data=float('nan')), 'data: .nan\n'),
        (Empty(), '{}\n'),
        (String(data='é\n: x'), "data: 'é\n\n  : x'\n"),
        (KeyValue(key='true', value='x' * 200), f"key: 'true'\nvalue: {'x' * 200}\n"),
    ],
)
def test_yaml_is_in_block_style_in_the_order_of_the_fields(message: Message, text: str) -> None:
    assert message_to_yaml(message) == text


def test_yaml_in_flow_style_has_lists_on_one_line_as_in_ros_2() -> None:
    # ROS 2's dumper gives a mapping no style of its own: only lists follow, and what is in them.
    message = DiagnosticStatus(message='m', values=[KeyValue(key='k', value='v')])
    text = message_to_yaml(message, flow_style=True)
    assert text.endswith("message: m\nhardware_id: ''\nvalues: [{key: k, value: v}]\n")


def test_yaml_writes_a_byte_as_a_character() -> None:
    assert 'level: "\\x02"\n' in message_to_yaml(DiagnosticStatus(level=b'\x02'))


@pytest.mark.parametrize(
    ('message', 'text'),
    [
        (Twist(), '0.0,0.0,0.0,0.0,0.0,0.0'),
        (JointState(name=['a', 'b'], position=[0.1, 1.0]), '0,0,,a,b,0.1,1.0,,'),
        (DiagnosticStatus(level=b'\x02', values=[KeyValue(key='k', value='v')]), "b'\\x02',,,,k,v"),
        (UInt8MultiArray(data=b'ab'), '0,97,98'),
        (Empty(), ''),
        (String(data='a,b'), 'a,b'),
    ],
)
def test_csv_joins_the_values_and_quotes_nothing(message: Message, text: str) -> None:
    assert message_to_csv(message) == text


def test_long_strings_and_arrays_are_truncated() -> None:
    numbers = Float64MultiArray(data=[float(n) for n in range(5)])
    assert message_to_yaml(String(data='x' * 20), truncate_length=5) == 'data: xxxxx...\n'
    assert message_to_ordereddict(String(data='x' * 20), truncate_length=5) == {'data': 'xxxxx...'}
    assert message_to_ordereddict(numbers, truncate_length=2)['data'] == [0.0, 1.0, '...']
    assert message_to_csv(numbers, truncate_length=2) == '0,0.0,1.0,...'


def test_what_is_just_as_long_as_allowed_is_left_whole() -> None:
    assert message_to_csv(String(data='abcde'), truncate_length=5) == 'abcde'
    assert message_to_ordereddict(JointState(position=[1.0, 2.0]), truncate_length=2)['position'] == [
        1.0,
        2.0,
    ]


def test_strings_within_a_truncated_array_are_truncated_too() -> None:
    names = message_to_ordereddict(JointState(name=['abc', 'd', 'e']), truncate_length=2)['name']
    assert names == ['ab...', 'd', '...']


def test_arrays_and_strings_give_way_to_descriptions() -> None:
    state = message_to_ordereddict(JointState(name=['a'], position=[1.0]), no_arr=True, no_str=True)
    assert state['name'] == '<sequence type: string, length: 1>'
    assert state['position'] == '<sequence type: double, length: 1>'
    assert state['header'] == {'stamp': {'sec': 0, 'nanosec': 0}, 'frame_id': '<string length: <0>>'}
    pose = message_to_ordereddict(PoseWithCovariance(), no_arr=True)
    assert pose['covariance'] == '<array type: double[36]>'
    status = message_to_ordereddict(DiagnosticStatus(), no_arr=True)
    assert status['values'] == '<sequence type: diagnostic_msgs/msg/KeyValue, length: 0>'


def test_csv_describes_arrays_too() -> None:
    text = message_to_csv(JointState(position=[1.0]), no_arr=True)
    assert text.endswith(
        '<sequence type: double, length: 1>,' + ','.join(['<sequence type: double, length: 0>'] * 2)
    )


def test_numpy_values_become_plain_ones() -> None:
    scan = LaserScan(angle_min=np.float64(0.5), ranges=np.array([1.5], dtype=np.float32))
    plain = message_to_ordereddict(scan)
    assert type(plain['angle_min']) is float
    assert plain['ranges'] == [1.5]
    covariance = message_to_ordereddict(PoseWithCovariance())['covariance']
    assert isinstance(covariance, list)
    assert {type(value) for value in covariance} == {float}


def test_nested_messages_become_ordered_dicts() -> None:
    plain = message_to_ordereddict(Twist())
    assert isinstance(plain['linear'], OrderedDict)
    assert list(plain['linear']) == ['x', 'y', 'z']


def test_what_is_no_message_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'int' object has no attribute 'get_fields_and_field_types'"):
        message_to_yaml(5)  # type: ignore[arg-type]


def test_slot_types_are_those_of_the_fields() -> None:
    slots = get_message_slot_types(Twist())
    assert list(slots) == ['linear', 'angular']
    assert list(slots.values()) == list(Twist.SLOT_TYPES)


def test_importing_it_loads_neither_numpy_nor_yaml() -> None:
    program = "import rosidl_runtime_py, sys; print({'numpy', 'yaml'} & set(sys.modules))"
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    assert done.stdout == 'set()\n'
