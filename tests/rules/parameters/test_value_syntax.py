from __future__ import annotations

import math
import subprocess
import sys

import pytest

from goalwire.rules.names import RuleSyntaxError
from goalwire.rules.parameters.value_syntax import parse_parameter_value


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('1.0', 1.0),
        ('true', True),
        ('True', True),
        ('yes', True),
        ('on', True),
        ('y', True),
        ('off', False),
        ('tRue', 'tRue'),
        ("'1'", '1'),
        ('"a b"', 'a b'),
        ('abc', 'abc'),
        (' x y ', 'x y'),
        ('null', 'null'),
        ('~', '~'),
        ("''", ''),
        ('!!str 5', '5'),
        ('0x10', 16),
        ('-0x10', -16),
        ('010', 8),
        ('08', 8.0),
        ('00', 0),
        ('0o10', '0o10'),
        ('-1', -1),
        ('+5', 5),
        ('1_000', '1_000'),
        ('2147483648', 2147483648),
        ('9223372036854775807', 2**63 - 1),
        ('9223372036854775808', 9.223372036854775808e18),
        ('-9223372036854775809', -9.223372036854775808e18),
        ('1e3', 1000.0),
        ('5.', 5.0),
        ('.5', 0.5),
        ('.', '.'),
        ('1e', '1e'),
        ('1e400', '1e400'),
        ('1e-400', '1e-400'),
        ('0e-400', 0.0),
        ('0x1p3', 8.0),
        ('1:30', '1:30'),
        ('2024-01-01', '2024-01-01'),
        ('.inf', math.inf),
        ('-.INF', -math.inf),
        ('infinity', math.inf),
        ('1 #c', 1),
        ('b:=c', 'b:=c'),
        ('a\nb', 'a b'),
        ('- 1', [1]),
        ('[1,2]', [1, 2]),
        ('[yes, no]', [True, False]),
        ('[a,b]', ['a', 'b']),
        ('["a", "1"]', ['a', '1']),
        ('[1e3]', [1000.0]),
        ('[0x10, 010]', [16, 8]),
        ('[]', None),
        ('#c', None),
        ('1' * 5000, '1' * 5000),
    ],
)
def test_a_value_reads_as_in_ros_2(text: str, value: object) -> None:
    parsed = parse_parameter_value(text)
    assert (type(parsed), parsed) == (type(value), value)


@pytest.mark.parametrize('text', ['.nan', 'nan', '-nan', '.NaN'])
def test_nan_is_a_double(text: str) -> None:
    value = parse_parameter_value(text)
    assert isinstance(value, float)
    assert math.isnan(value)


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('[1.0,2]', "Sequence should be of same type. Value type 'integer' do not belong at line_num 1"),
        ('[1,a]', "Sequence should be of same type. Value type 'string' do not belong at line_num 1"),
        ('[1,true]', "Sequence should be of same type. Value type 'bool' do not belong at line_num 1"),
        ('[1,2.5]', "Sequence should be of same type. Value type 'double' do not belong at line_num 1"),
        ('{a: 1}', 'Unknown YAML event'),
        ('a: b', 'Unknown YAML event'),
        ('*x', 'Unknown YAML event'),
        ('[1,2', 'Error parsing an event'),
        ('"x', 'Error parsing an event'),
        ('@x', 'Error parsing an event'),
        ('caf\udce9', 'Error parsing an event: the bytes are not UTF-8 text'),
        ('|', 'No value at line 1'),
        ('-', 'No value at line 1'),
    ],
)
def test_what_is_no_value_is_told_in_the_words_of_ros_2(text: str, error: str) -> None:
    with pytest.raises(RuleSyntaxError) as raised:
        parse_parameter_value(text)
    assert str(raised.value) == error


def test_a_sequence_of_sequences_is_refused_where_rcl_keeps_only_the_last() -> None:
    with pytest.raises(RuleSyntaxError, match='Sequences of sequences are not parameters, at line 1'):
        parse_parameter_value('[[1],[2]]')


def test_plain_values_need_no_yaml() -> None:
    program = (
        'import sys\n'
        'from goalwire.rules.arguments import parse_arguments\n'
        'arguments = ["--ros-args", "-p", "a:=1.5", "-p", "b:=on", "-p", "c:=/some/file.txt", "-r", "x:=y"]\n'
        'assert len(parse_arguments(arguments).parameters) == 3\n'
        'loaded = {"yaml", "numpy", "asyncio", "rich"} & set(sys.modules)\n'
        'assert not loaded, loaded\n'
    )
    subprocess.run([sys.executable, '-c', program], check=True, timeout=30)
