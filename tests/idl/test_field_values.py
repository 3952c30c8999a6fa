"""Values that people write for a message: what is taken, what is refused, and how the refusal reads."""

from __future__ import annotations

import math
from typing import Any

import pytest
from helpers.names import fresh_package

from goalwire.errors import FieldValueError
from goalwire.idl import register_definitions
from goalwire.idl.field_values import fit_fields, plain_values, read_yaml
from goalwire.idl.model import MessageDefinition
from goalwire.idl.registry import message_definition

DEFINITION = """
bool on
byte octet
char letter
int8 small
uint64 large
float32 single
float64 double
string text
string<=4 short
wstring wide
float64[3] three
int16[<=2] few
string[] names
bool[] switches
uint8[] data
byte[] octets
builtin_interfaces/Time due
std_msgs/Header header
geometry_msgs/Point place
geometry_msgs/Point[] places
"""


@pytest.fixture(scope='module')
def definition() -> MessageDefinition:
    package = fresh_package()
    register_definitions(package, {'msg/Everything': DEFINITION})
    return message_definition(f'{package}/msg/Everything')


def fit(definition: MessageDefinition, text: str) -> dict[str, Any]:
    return fit_fields(definition, read_yaml(text), stamps=True)


@pytest.mark.parametrize(
    ('text', 'field', 'value'),
    [
        ('on: true', 'on', True),
        ('on: off', 'on', False),
        ('on: 1', 'on', True),
        ('octet: 7', 'octet', b'\7'),
        ('letter: 65', 'letter', 65),
        ('small: 3.0', 'small', 3),
        ('small: "-5"', 'small', -5),
        ('large: 0xffffffffffffffff', 'large', 2**64 - 1),
        ('double: 1', 'double', 1.0),
        ('double: 1e-3', 'double', 0.001),
        ('double: .inf', 'double', math.inf),
        ('text: 005', 'text', '005'),
        ('text: on', 'text', 'on'),
        ('text: 1.10', 'text', '1.10'),
        ('text: 2026-13-01', 'text', '2026-13-01'),
        ('text: "7"', 'text', '7'),
        ('wide: ä', 'wide', 'ä'),
        ('three: [1, 2.5, 1e3]', 'three', [1.0, 2.5, 1000.0]),
        ('few: []', 'few', []),
        ('names: [left, 7, on]', 'names', ['left', '7', 'on']),
        ('data: !!binary AQI=', 'data', [1, 2]),
        ('octets: [1, 2]', 'octets', [b'\1', b'\2']),
        ('due: now', 'due', 'now'),
        ('due: {sec: 1}', 'due', {'sec': 1}),
        ('header: auto', 'header', 'auto'),
        ('header: {stamp: now, frame_id: 7}', 'header', {'stamp': 'now', 'frame_id': '7'}),
        ('places: [{x: 1}]', 'places', [{'x': 1.0}]),
    ],
)
def test_what_cannot_be_misunderstood_is_taken(
    definition: MessageDefinition, text: str, field: str, value: object
) -> None:
    fitted = fit(definition, text)[field]
    assert fitted == value
    assert type(fitted) is type(value)


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('on: "false"', "on: give true or false without quotes, not 'false' (bool)"),
        ('on: flase', "on: give true or false, not 'flase' (bool)"),
        ('on: 2', 'on: give true or false, not 2 (bool)'),
        ('on: [true]', 'on: give true or false, not [True] (bool)'),
        ('octet: 256', 'octet: give a number from 0 to 255, not 256 (byte)'),
        ('small: 3.7', 'small: give a whole number such as 3, not 3.7 (int8)'),
        ('small: true', 'small: give a whole number such as 3, not true (int8)'),
        ('small: .nan', 'small: give a whole number such as 3, not .nan (int8)'),
        ('small: 128', 'small: give a number from -128 to 127, not 128 (int8)'),
        ('small:', 'small: give a whole number such as 3, not nothing (int8)'),
        ('double: 1.0e999', "double: give a number such as 1.5, not '1.0e999' (float64)"),
        ('double: "1e999"', "double: give a number such as 1.5, not '1e999' (float64)"),
        ('double: 1' + 5000 * '0', 'double: give a number such as 1.5, not 1000'),
        ('double: x', "double: give a number such as 1.5, not 'x' (float64)"),
        ('double: {a: 1}', "double: give a number such as 1.5, not {'a': 1} (float64)"),
        ('single: 1e39', "single: give a number from -3.40282e+38 to 3.40282e+38, not '1e39' (float32)"),
        ('text: ~', 'text: give a text such as "~", in quotes, not ~ (string)'),
        ('text: [a]', "text: give a text such as 'a', not ['a'] (string)"),
        ('text: "a\\0b"', 'text: a text cannot contain a NUL (string)'),
        ('short: abcde', 'short: 4 characters at most, not 5 (string<=4)'),
        ('three: [1, 2]', 'three: there must be 3 items, not 2 (float64[3])'),
        ('three: [1, 2, x]', "three[2]: give a number such as 1.5, not 'x' (float64)"),
        ('few: [1, 2, 3]', 'few: there may be 2 items at most, not 3 (int16[<=2])'),
        ('names: left_arm', "names: give a list such as [left_arm], not 'left_arm' (string[])"),
        ('switches: true', 'switches: give a list such as [true, true], not true (bool[])'),
        ('due: soon', "due: give the fields of a message such as {sec: …, nanosec: …}, not 'soon'"),
        ('place: [1, 2, 3]', 'place: give the fields of a message such as {x: …, y: …}, not [1, 2, 3]'),
        ('places: {x: 1}', "places: give a list such as [{…}, {…}], not {'x': 1} (geometry_msgs/Point[])"),
        ('places: [{z: 0}, {w: 1}]', "places[1]: there is no field 'w'; the fields are: x, y, z"),
    ],
)
def test_what_does_not_fit_is_refused_with_field_type_and_example(
    definition: MessageDefinition, text: str, problem: str
) -> None:
    with pytest.raises(FieldValueError) as raised:
        fit(definition, text)
    assert str(raised.value).startswith(problem)


def test_a_field_may_have_the_name_of_a_yaml_boolean() -> None:
    assert plain_values(read_yaml('{on: 1, off: 2, y: 3, 4: 5}')) == {'on': 1, 'off': 2, 'y': 3, '4': 5}


def test_broken_yaml_is_told_with_its_place() -> None:
    with pytest.raises(FieldValueError, match=r'that is not YAML: .* \(line 2, column'):
        read_yaml('a: 1\nb: [')
    with pytest.raises(FieldValueError, match='nested too deeply'):
        read_yaml('[' * 5000)
