"""Values and files by YAML's own rules."""

from __future__ import annotations

import datetime as dt
import math
from typing import Any

import pytest

from goalwire.errors import FileShapeError
from goalwire.rules.parameters import Type
from goalwire.rules.parameters.plain_yaml import flat_values, read_typed_text, read_typed_value


@pytest.mark.parametrize(
    ('text', 'type_', 'value'),
    [
        ('1', Type.INTEGER, 1),
        ('0x10', Type.INTEGER, 16),
        ('1_000', Type.INTEGER, 1000),
        ('1.0', Type.DOUBLE, 1.0),
        ('.inf', Type.DOUBLE, math.inf),
        ('99999999999999999999', Type.DOUBLE, 1e20),
        ('True', Type.BOOL, True),
        ('yes', Type.BOOL, True),
        ('[1,2]', Type.INTEGER_ARRAY, [1, 2]),
        ('- 1', Type.INTEGER_ARRAY, [1]),
        ('[true]', Type.BOOL_ARRAY, [True]),
        ('[1.0,2.5]', Type.DOUBLE_ARRAY, [1.0, 2.5]),
        ('[a,b]', Type.STRING_ARRAY, ['a', 'b']),
        ('[]', Type.BOOL_ARRAY, []),
        ('"1"', Type.STRING, '1'),
        ('abc', Type.STRING, 'abc'),
    ],
)
def test_text_has_the_type_that_yaml_gives_it(text: str, type_: Type, value: Any) -> None:
    found = read_typed_text(text)
    assert found == (type_, value)
    assert type(found[1]) is type(value)


@pytest.mark.parametrize(
    'text',
    ['', 'null', '~', '1e3', '[1,2.0]', '[[1],[2]]', '{a: 1}', 'a: b', '[1, 2', '"x', '@x', '!foo x',
     '2024-01-01', '!!binary aGk=', '[99999999999999999999]', '--- 1\n--- 2'],
)  # fmt: skip
def test_text_that_no_parameter_holds_is_a_string_as_it_stands(text: str) -> None:
    assert read_typed_text(text) == (Type.STRING, text)


def test_values_of_a_file_keep_their_types() -> None:
    assert read_typed_value('a', '1') == (Type.STRING, '1')
    assert read_typed_value('a', 1.0e-7) == (Type.DOUBLE, 1e-7)
    assert read_typed_value('a', None) == (Type.STRING, 'null')
    assert read_typed_value('a', dt.date(2024, 1, 2)) == (Type.STRING, '2024-01-02')
    with pytest.raises(FileShapeError, match=r"^parameter 'a\.b': \[1, 'x'\] is not a value, nor a sequence"):
        read_typed_value('a.b', [1, 'x'])


CONTENT = {
    '/**': {'ros__parameters': {'a': 1, 'w': 1}},
    '/ns/pn': {'ros__parameters': {'a': 2, 'g': {'h': [1, 2]}}},
    'pn': {'ros__parameters': {'c': 'x', 5: 6}},
}


@pytest.mark.parametrize(
    ('nodes', 'use_wildcard', 'values'),
    [
        (None, False, {'a': 2, 'g.h': [1, 2], 'c': 'x', '5': 6}),
        (None, True, {'a': 2, 'w': 1, 'g.h': [1, 2], 'c': 'x', '5': 6}),
        (['/ns/pn'], False, {'a': 2, 'g.h': [1, 2]}),
        (['/ns/pn'], True, {'a': 2, 'w': 1, 'g.h': [1, 2]}),
        (['/**'], False, {'a': 1, 'w': 1}),
    ],
)
def test_nodes_are_chosen_by_their_names_as_written(
    nodes: list[str] | None, use_wildcard: bool, values: dict[str, object]
) -> None:
    assert flat_values(CONTENT, nodes, use_wildcard=use_wildcard) == values


@pytest.mark.parametrize('node', ['/left/arm', 'left/arm'])
def test_a_node_may_stand_below_its_namespace(node: str) -> None:
    content = {'/left': {'arm': {'ros__parameters': {'a': 1}}, 'leg': {'ros__parameters': {'b': 2}}}}
    assert flat_values(content, [node], use_wildcard=False) == {'a': 1}
    assert flat_values(content, None, use_wildcard=False) == {'a': 1, 'b': 2}


def test_a_node_may_stand_in_both_ways_and_has_the_values_of_both() -> None:
    content = {
        '/left': {'arm': {'ros__parameters': {'a': 1}}},
        '/left/arm': {'ros__parameters': {'b': 2}},
        '/*/arm': {'ros__parameters': {'w': 3}},
    }
    assert flat_values(content, ['/left/arm'], use_wildcard=False) == {'a': 1, 'b': 2}
    assert flat_values(content, None, use_wildcard=False) == {'a': 1, 'b': 2}
    assert flat_values(content, None, use_wildcard=True) == {'a': 1, 'b': 2, 'w': 3}


@pytest.mark.parametrize('pattern', ['/**/arm', '/*/arm', '/left/*'])
def test_a_pattern_gives_values_below_those_of_the_name(pattern: str) -> None:
    content = {
        '/left/arm': {'ros__parameters': {'a': 1}},
        pattern: {'ros__parameters': {'a': 2, 'w': 2}},
        '/*': {'leg': {'ros__parameters': {'b': 2}}},
    }
    assert flat_values(content, ['/left/arm'], use_wildcard=True) == {'a': 1, 'w': 2}
    assert flat_values(content, ['/left/arm'], use_wildcard=False) == {'a': 1}
    assert flat_values(content, ['/left/leg'], use_wildcard=True)['b'] == 2


@pytest.mark.parametrize(
    ('content', 'error'),
    [
        (CONTENT, r"^Param file does not contain parameters for nope,only for nodes: \['/\*\*', '/ns/pn', "),
        (None, r'^a parameter file holds names of nodes, each with ros__parameters; not None'),
        ([1], r'^a parameter file holds names of nodes'),
        ({'nope': 5}, r'^YAML file is not a valid ROS parameter file for node nope$'),
        ({'nope': {'a': 1}}, r'^YAML file is not a valid ROS parameter file for node nope$'),
        ({'nope': {'ros__parameters': None}}, r'^YAML file is not a valid ROS parameter file for node nope$'),
    ],
)  # fmt: skip
def test_a_file_without_what_is_wanted_is_refused(content: object, error: str) -> None:
    with pytest.raises(RuntimeError, match=error):
        flat_values(content, ['nope'], use_wildcard=False)


def test_a_name_with_a_namespace_is_missed_in_the_words_of_rclpy() -> None:
    error = r'^Param file does not contain selected parameters: none for /no/pn,only for nodes: '
    with pytest.raises(FileShapeError, match=error):
        flat_values(CONTENT, ['/no/pn'], use_wildcard=False)


def test_a_file_of_wildcards_alone_has_nothing_for_nobody() -> None:
    with pytest.raises(FileShapeError, match=r'^Param file does not contain selected parameters$'):
        flat_values({'/**': {'ros__parameters': {'a': 1}}}, None, use_wildcard=False)
