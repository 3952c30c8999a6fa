"""Forms are made from definitions, and hold values to them."""

from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped

from goalwire.apps.console.state.form_model import (
    FormField,
    check,
    complete,
    defaults_of,
    fill,
    form_of,
    list_text,
    parse_list,
    parse_yaml,
    time_text,
    to_yaml,
    without_defaults,
)
from goalwire.errors import FieldValueError
from goalwire.idl.field_values import plain_values
from goalwire.idl.registry import register_definitions

register_definitions(
    'console_forms',
    {
        'msg/Part': 'float64 size\n',
        'msg/Everything': """
uint8 MODE_OFF=0
uint8 MODE_ON=1
uint8 LIMIT=9
uint8 mode 1          # how it runs
int8 small
float32 speed         # [m/s] forwards, 0.0 to 2.5
float64 angle         # rad, positive
string<=4 name 'abc'
int32[3] three
int16[<=2] few
string[] names
console_forms/Part part
console_forms/Part[<=2] parts
builtin_interfaces/Time stamp
byte flag
bool on true
string<=5[<=3] tags
bool[] switches
""",
    },
)
FIELDS = form_of('console_forms/msg/Everything')


def field(name: str) -> FormField:
    return next(each for each in FIELDS if each.name == name)


def test_units_ranges_and_comments_come_from_the_definition() -> None:
    assert (field('speed').unit, field('speed').hint) == ('m/s', '0.0 to 2.5')
    assert (field('angle').unit, field('angle').hint) == ('rad', '')
    assert field('mode').comment == 'how it runs'
    assert (field('small').least, field('small').most) == (-128, 127)
    assert (field('three').capacity, field('three').exact) == (3, True)
    assert (field('few').capacity, field('few').exact) == (2, False)
    assert field('part').fields[0].name == 'size'


def test_constants_that_begin_with_a_fields_name_are_its_choices() -> None:
    assert field('mode').choices == (('OFF', 0), ('ON', 1))
    status = next(each for each in form_of('action_msgs/msg/GoalStatus') if each.name == 'status')
    assert ('SUCCEEDED', 4) in status.choices


@pytest.mark.parametrize(
    ('values', 'sent'),
    [
        ({'small': '12'}, {'small': 12}),
        ({'speed': '1e-3'}, {'speed': 0.001}),
        ({'speed': 2}, {'speed': 2.0}),
        ({'three': '1, 2, 3'}, {'three': [1, 2, 3]}),
        ({'three': [1, 2, 3]}, {'three': [1, 2, 3]}),
        ({'names': 'a, "b, c"'}, {'names': ['a', 'b, c']}),
        ({'names': ''}, {'names': []}),
        (
            {'names': "yes, 12, it's, '', 'isn''t', {a: b} # c"},
            {'names': ['yes', '12', "it's", '', "isn't", '{a: b} # c']},
        ),
        ({'names': '[a, b,]'}, {'names': ['a', 'b']}),
        ({'names': '[a], [b]'}, {'names': ['[a]', '[b]']}),
        ({'switches': 'true, False'}, {'switches': [True, False]}),
        ({'stamp': '1700000000.000000005'}, {'stamp': {'sec': 1_700_000_000, 'nanosec': 5}}),
        ({'part': {'size': '2'}}, {'part': {'size': 2.0}}),
        ({'parts': [{'size': 1}]}, {'parts': [{'size': 1.0}]}),
        ({'stamp': 'now'}, {'stamp': 'now'}),
        ({'stamp': '1.5'}, {'stamp': {'sec': 1, 'nanosec': 500_000_000}}),
        ({'name': 'äb'}, {'name': 'äb'}),
    ],
)
def test_what_fits_is_converted(values: dict[str, Any], sent: dict[str, Any]) -> None:
    assert check(FIELDS, values) == sent


@pytest.mark.parametrize(
    ('values', 'path', 'problem'),
    [
        ({'small': '128'}, 'small', '-128 to 127'),
        ({'small': '1.5'}, 'small', 'whole number'),
        ({'small': 'x'}, 'small', 'give a whole number such as 3'),
        ({'small': '1' + 400 * '0'}, 'small', '-128 to 127'),
        ({'small': True}, 'small', 'give a whole number such as 3'),
        ({'speed': float('nan')}, 'speed', 'finite'),
        ({'speed': '.inf'}, 'speed', 'give a number'),
        ({'on': 'yes'}, 'on', 'true or false'),
        ({'name': 'abcde'}, 'name', '4 characters'),
        ({'name': 3}, 'name', 'give a text'),
        ({'three': '1, 2'}, 'three', '3 items'),
        ({'few': '1, 2, 3'}, 'few', '2 items at most'),
        ({'few': '1, 99999'}, 'few[1]', '-32768 to 32767'),
        ({'few': '1, {'}, 'few[1]', 'give a whole number such as 3'),
        ({'few': 3}, 'few', 'give a list'),
        ({'few': '[[1], [2]]'}, 'few[0]', 'give a whole number such as 3'),
        ({'names': '"a'}, 'names[0]', 'must end with it'),
        ({'names': '"a" b'}, 'names[0]', 'must end with it'),
        ({'names': ' , a'}, 'names[0]', 'nothing before the comma'),
        ({'names': r'a, "\x"'}, 'names[1]', 'after a backslash'),
        ({'tags': 'abc, abcdef'}, 'tags[1]', '5 characters at most'),
        ({'switches': 'true, perhaps'}, 'switches[1]', 'true or false'),
        ({'speed': '1e39'}, 'speed', 'from -3.40282e+38'),
        ({'angle': '1' + 400 * '0'}, 'angle', 'a number that a double holds'),
        ({'name': 'äöü'}, 'name', '4 bytes at most, not 6'),
        ({'part': 3}, 'part', 'the fields of'),
        ({'part': {'size': 'x'}}, 'part.size', 'give a number'),
        ({'parts': [{'size': 1}, {'sise': 1}]}, 'parts[1]', "no field 'sise'"),
        ({'parts': [1]}, 'parts[0]', 'the fields of'),
        ({'stamp': 'soon'}, 'stamp', 'give a number'),
        ({'stamp': -1}, 'stamp', "'now'"),
        ({'nothing': 1}, '', "no field 'nothing'"),
    ],
)
def test_what_does_not_fit_is_named(values: dict[str, Any], path: str, problem: str) -> None:
    with pytest.raises(FieldValueError) as raised:
        check(FIELDS, values)
    assert raised.value.path == path
    assert problem in raised.value.problem


def test_defaults_are_the_messages_own_and_headers_are_stamped_when_sent() -> None:
    fields = form_of('geometry_msgs/msg/PoseStamped')
    values = check(fields, defaults_of(fields, PoseStamped()))
    assert values['header']['stamp'] == 'now'
    assert values['pose']['orientation']['w'] == 1.0
    message = fill(PoseStamped, values, Time(sec=7))
    assert message.header.stamp == Time(sec=7)
    assert fill(PoseStamped, without_defaults(values, values), Time()) == PoseStamped()


def test_yaml_and_back() -> None:
    values = {'name': 'now: then', 'three': [1, 2, 3], 'part': {'size': 0.5}}
    assert plain_values(parse_yaml(to_yaml(values))) == values
    for text in (
        '[1]',
        'a: [',
        '!!python/object/apply:os.system [true]',
        '- ' * 100_000,
    ):
        with pytest.raises(FieldValueError):
            parse_yaml(text)
    for number in ('2024-13-01', '1' + 5000 * '0'):
        with pytest.raises(FieldValueError):
            check(FIELDS, parse_yaml(f'small: {number}'))


@pytest.mark.parametrize(
    'texts',
    [
        [],
        [''],
        ['', ''],
        ['a, b', 'c'],
        ["it's", "'it", '"it"', 'say "it"', "''"],
        [' a', 'b ', 'c\td', 'e\nf', '\\', '\x85'],
        ['[', '[x]', ']', '[a, b]'],
        ['yes', 'null', '~', '#', '&a', '*a', '!a', '{', 'a: b', '1', '🙂'],
    ],
)
def test_a_list_of_texts_is_read_as_it_was_written(texts: list[str]) -> None:
    assert parse_list(list_text(texts)) == texts


def test_what_is_not_given_is_the_default_in_items_too() -> None:
    defaults = {field.name: '' for field in FIELDS} | {'part': {'size': 0.5}}
    whole = complete(FIELDS, {'parts': [{'size': 2.0}, {}], 'small': 3}, defaults)
    assert whole['parts'] == [{'size': 2.0}, {'size': 0.0}]
    assert (whole['small'], whole['part'], whole['name']) == (3, {'size': 0.5}, '')
    whole['part']['size'] = 1.0
    assert defaults['part'] == {'size': 0.5}


def test_times_are_written_to_the_nanosecond() -> None:
    assert time_text({'sec': 1_700_000_000, 'nanosec': 5}) == '1700000000.000000005'
    assert time_text({'sec': 1, 'nanosec': 500_000_000}) == '1.5'
    assert time_text({'sec': 0, 'nanosec': 0}) == '0'
