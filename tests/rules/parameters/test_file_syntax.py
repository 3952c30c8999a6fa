"""Parameter files: which nodes they mean, what they give, and what is said of mistakes."""

from __future__ import annotations

import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.rules.names import RuleSyntaxError
from goalwire.rules.parameters.file_syntax import matches, parse_parameter_file


def below(node: str, parameters: str = 'a: 1') -> bytes:
    return f'{node}:\n  ros__parameters:\n    {parameters}\n'.encode()


@pytest.mark.parametrize(
    ('pattern', 'meant'),
    [
        ('/**', {'/pn', '/ns/pn', '/ns/sub/pn'}),
        ('**', {'/pn', '/ns/pn', '/ns/sub/pn'}),
        ('/*', {'/pn'}),
        ('*', {'/pn'}),
        ('/*/pn', {'/ns/pn'}),
        ('*/pn', {'/ns/pn'}),
        ('/*/*', {'/ns/pn'}),
        ('/ns/*', {'/ns/pn'}),
        ('/ns/**', {'/ns/pn', '/ns/sub/pn'}),
        ('/**/pn', {'/pn', '/ns/pn', '/ns/sub/pn'}),
        ('/**/*', {'/pn', '/ns/pn', '/ns/sub/pn'}),
        ('/*/**/pn', {'/ns/pn', '/ns/sub/pn'}),
        ('/ns/*/pn', {'/ns/sub/pn'}),
        ('pn', {'/pn'}),
        ('/pn', {'/pn'}),
        ('ns/pn', {'/ns/pn'}),
        ('/PN', set()),
        ('/p', set()),
    ],
)
def test_a_written_name_means_nodes(pattern: str, meant: set[str]) -> None:
    nodes = ['/pn', '/ns/pn', '/ns/sub/pn']
    assert {node for node in nodes if matches(pattern, node)} == meant


@pytest.mark.parametrize(
    ('text', 'nodes'),
    [
        ('', {}),
        ('# nothing\n', {}),
        ('ns:\n  pn:\n    ros__parameters: {a: 1}\n  x:\n    ros__parameters: {b: 2}\n',
         {'ns/pn': {'a': 1}, 'ns/x': {'b': 2}}),
        ('ns/:\n  pn:\n    ros__parameters: {a: 1}\n', {'ns/pn': {'a': 1}}),
        ('/**:\n  pn:\n    ros__parameters: {a: 1}\n', {'/**/pn': {'a': 1}}),
        ('/a:\n  ros__parameters: {x: 1, y: 1}\n/a:\n  ros__parameters: {x: 2}\n', {'/a': {'x': 2, 'y': 1}}),
        ('---\n/a:\n  ros__parameters: {x: 1}\n---\n/b:\n  ros__parameters: {y: 2}\n',
         {'/a': {'x': 1}, '/b': {'y': 2}}),
        ('/a:\n  ros__parameters: {}\n', {'/a': {}}),
        ('/a:\n  ros__parameters: []\n', {'/a': {}}),
        ('\ufeff/a:\n  ros__parameters: {x: ü}\n', {'/a': {'x': 'ü'}}),
    ],
)  # fmt: skip
def test_nodes_may_stand_below_namespaces_and_several_times(text: str, nodes: object) -> None:
    assert parse_parameter_file(text.encode()) == nodes


@pytest.mark.parametrize(
    ('parameters', 'values'),
    [
        ('{a: {b: {c: 1, d: 2}, e: 3}, f: 4}', {'a.b.c': 1, 'a.b.d': 2, 'a.e': 3, 'f': 4}),
        ("{g: {h: {i: 2, j: [1,2]}}, 'k.l': 3}", {'g.h.i': 2, 'g.h.j': [1, 2], 'k.l': 3}),
        ('{a: 1, a: 2}', {'a': 2}),
        ('{a.b: 1, a: {b: 2}}', {'a.b': 2}),
        ('{a: {}, b: 1}', {'b': 1}),
        ('{1: 5, true: 6, ~: 7}', {'1': 5, 'true': 6, '~': 7}),
        ('{a: !!str 5, b: !foo 5, c: "5", d: 010, e: 1e3, f: yes}',
         {'a': '5', 'b': 5, 'c': '5', 'd': 8, 'e': 1000.0, 'f': True}),
        ('{a: 2024-01-01, b: 1:30, c: ~, d: null}', {'a': '2024-01-01', 'b': '1:30', 'c': '~', 'd': 'null'}),
        ('{a: &x 1, b: []}', {'a': 1, 'b': None}),
        ('{a: [x, ~, "1"]}', {'a': ['x', '~', '1']}),
        ('{ros__parameters: {b: 1}}', {'ros__parameters.b': 1}),
        ('a: |\n      hello\n      w', {'a': 'hello\nw\n'}),
    ],
)  # fmt: skip
def test_values_are_read_as_arguments_are(parameters: str, values: object) -> None:
    assert parse_parameter_file(below('/n', parameters)) == {'/n': values}


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('/**:\n  a: 1\n', 'Cannot have a value before ros__parameters at line 2'),
        ('/**:\n', 'Cannot have a value before ros__parameters at line 1'),
        ('/**:\n  ros__parameters: 5\n', 'Cannot have a value before ros__parameters at line 2'),
        ('/**:\n  ros__parameters:\n', 'Cannot have a value before ros__parameters at line 2'),
        ('/**:\n  ros__parameters: [1]\n', 'Cannot have a value before ros__parameters at line 2'),
        ('/**:\n  ros__parameters:\n    a: 1\n  b: 2\n',
         'Cannot have a value before ros__parameters at line 4'),
        ('ros__parameters:\n  a: 1\n', 'There are no node names before ros__parameters at line 1'),
        ('/n:\n  ros__parameters: {a: 1}\n  ros__parameters: {b: 1}\n',
         "'/n' has ros__parameters twice: the second at line 3"),
        ('/n:\n  ros__parameters: {a: 1}\n  sub:\n    ros__parameters: {b: 1}\n',
         "'sub' cannot follow ros__parameters of '/n' at line 3"),
        ('- a\n', 'Sequences cannot be key at line 1'),
        ('a:\n - 1\n', 'Sequences can only be values and not keys in params. Error at line 2'),
        ('text', 'There must be names of nodes, each with ros__parameters, instead of a value at line 1'),
    ],
)  # fmt: skip
def test_a_shape_that_makes_no_sense_is_told_with_its_line(text: str, error: str) -> None:
    with pytest.raises(RuleSyntaxError) as raised:
        parse_parameter_file(text.encode())
    assert str(raised.value).startswith(error)


@pytest.mark.parametrize(
    ('parameters', 'error'),
    [
        ('a: [1, 2.0]',
         "Sequence should be of same type. Value type 'double' do not belong at line_num 3"),
        ('a: [1,\n      x]',
         "Sequence should be of same type. Value type 'string' do not belong at line_num 4"),
        ('a: [[1,2],[3,4]]', 'Sequences of sequences are not parameters, at line 3'),
        ('a: [{b: 1}]', 'Mappings in sequences are not parameters, at line 3'),
        ('a: &x 1\n    b: *x', 'Will not support aliasing at line 4'),
        ('a: &x 1\n    b: [*x]', 'Will not support aliasing at line 4'),
        ('a: &x 1\n    *x : 2', 'Will not support aliasing at line 4'),
        ('a:\n    b: 1', 'No value at line 3'),
        ('"": 5', 'No key at line 3'),
        ('? [a]\n    : 5', 'Sequences cannot be key at line 3'),
        ('? {a: 1}\n    : 5', 'Mappings cannot be key at line 3'),
    ],
)  # fmt: skip
def test_a_value_that_makes_no_sense_is_told_with_its_line(parameters: str, error: str) -> None:
    with pytest.raises(RuleSyntaxError) as raised:
        parse_parameter_file(below('/**', parameters))
    assert str(raised.value) == error


@pytest.mark.parametrize(
    ('name', 'complaint'),
    [
        ('/n*/pn', "namespace must not contain characters other than alphanumerics, '_', or '/'"),
        ('/a b/pn', "namespace must not contain characters other than alphanumerics, '_', or '/'"),
        ('/ n', "node name must not contain characters other than alphanumerics or '_'"),
        ('~', "node name must not contain characters other than alphanumerics or '_'"),
        ('/***', "node name must not contain characters other than alphanumerics or '_'"),
        ('/ns/1pn', 'node name must not start with a number'),
        ('/ns/pn/', 'node name must not be empty'),
        ('/', 'node name must not be empty'),
    ],
)
def test_a_node_name_that_ros_2_forbids_is_told_with_its_line(name: str, complaint: str) -> None:
    with pytest.raises(RuleSyntaxError) as raised:
        parse_parameter_file(b'\n\n' + below(name))
    assert str(raised.value) == f"'{name}': {complaint} at line 3"


def test_slashes_are_not_repeated() -> None:
    with pytest.raises(RuleSyntaxError, match=r"^'/ns//pn' contains repeated forward slash at line 2$"):
        parse_parameter_file(b'/ns:\n  /pn:\n    ros__parameters: {a: 1}\n')


@pytest.mark.parametrize(
    ('data', 'line'),
    [
        (b'/**:\n  ros__parameters:\n\ta: 1\n', 3),
        (b'/**:\n  ros__parameters:\n    a: @x\n', 3),
        (b'/**:\n  ros__parameters:\n    : 1\n', 3),
        (b'/**: \xff\n', 0),
    ],
)
def test_what_is_no_yaml_is_told_with_its_line(data: bytes, line: int) -> None:
    with pytest.raises(RuleSyntaxError, match=rf'^Error parsing a event near line {line}: '):
        parse_parameter_file(data)


def test_a_file_nested_without_end_is_refused() -> None:
    with pytest.raises(RuleSyntaxError, match=r'nested too deeply|^Error parsing a event'):
        parse_parameter_file(b'{a: ' * 20_000)


@pytest.mark.parametrize(
    'pattern', ['/**' * 60 + '/z', '/**/*' * 60 + '/z', '/**/a' * 40 + '/z', '/*' * 200, '/**' * 9000 + '/z']
)
def test_matching_takes_no_longer_for_many_stars(pattern: str) -> None:
    started = time.process_time()
    assert not matches(pattern, '/a' * 122)
    assert time.process_time() - started < 2  # s; going back through all of them would take ages


@given(
    st.lists(st.sampled_from(['**', '*', 'a', 'b']), min_size=1, max_size=7),
    st.lists(st.sampled_from(['a', 'b', 'c']), min_size=1, max_size=7),
)
def test_matching_is_that_of_the_obvious_expression(pattern: list[str], name: list[str]) -> None:
    parts = {'**': r'(/\w+)*', '*': r'/\w+'}
    expression = ''.join(parts.get(part, f'/{part}') for part in pattern)
    written, full = '/' + '/'.join(pattern), '/' + '/'.join(name)
    assert matches(written, full) == (re.fullmatch(expression, full) is not None)


@pytest.mark.parametrize(
    'text', ['/n:\n\tros__parameters:\n', '/n:\n  ros__parameters:\n    a: 1\n \tb: 2\n']
)
def test_a_tab_that_indents_is_named(text: str) -> None:
    with pytest.raises(RuleSyntaxError, match=r'near line [24]: .*\(the line begins with a tab: YAML is ind'):
        parse_parameter_file(text.encode())
