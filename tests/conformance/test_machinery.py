"""The differences of two traces that are reported, and those that are not, without the real rclpy."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from helpers.processes import Program
from helpers.traces import Outcome, complaints, read_trace

TRACER = Path(__file__).parent / 'tracer.py'
PROGRAM = '''\
"""A docstring."""
import sys
value = 6
value * 7
None
print('seen') or value
def broken():
    raise FileNotFoundError(2, 'gone')
broken()
missing = broken()
(
    value
    + 1
)
object()
type(sys)
KeyboardInterrupt
raise KeyboardInterrupt
value
'''


@pytest.fixture
def traced(tmp_path: Path) -> list[Outcome]:
    """The trace of PROGRAM."""
    (tmp_path / 'program.py').write_text(PROGRAM)
    with Program(TRACER, str(tmp_path / 'program.py'), str(tmp_path / 'trace')) as running:
        assert running.succeed() == ''
    return read_trace((tmp_path / 'trace').read_text())


def test_every_expression_and_every_failure_is_told_in_order(traced: list[Outcome]) -> None:
    assert [(outcome.call, str(outcome)) for outcome in traced] == [
        ('value * 7', '42'),
        ('None', 'None'),
        ("print('seen') or value", '6 (printed: seen\n)'),
        ('broken()', 'FileNotFoundError: [Errno 2] gone'),
        ('missing = broken()', 'FileNotFoundError: [Errno 2] gone'),
        ('(\n    value\n    + 1\n)', '7'),
        ('object()', '<object>'),
        ('type(sys)', '<class module>'),
        ('KeyboardInterrupt', '<class KeyboardInterrupt>'),
        ('raise KeyboardInterrupt', 'KeyboardInterrupt: '),
        ('value', '6'),
    ]
    assert traced[3].raises == ('FileNotFoundError', 'OSError', 'Exception', 'BaseException')


def gives(value: str, call: str = 'f()') -> Outcome:
    return Outcome(call, gives=value)


def raises(*kinds: str, text: str = 'bad') -> Outcome:
    return Outcome('f()', raises=kinds, text=text)


@pytest.mark.parametrize(
    ('ours', 'real'),
    [
        (gives('1'), gives('2')),
        (gives('1'), raises('ValueError')),
        (raises('ValueError'), gives('1')),
        (raises('TypeError', 'Exception'), raises('ValueError', 'Exception')),
        (raises('ValueError', 'Exception'), raises('EncodeError', 'ValueError', 'Exception')),
        (raises('ValueError', text='bad'), raises('ValueError', text='too bad')),
        (Outcome('f()', 'None', printed='x'), gives('None')),
    ],
)
def test_what_differs_is_reported_unless_it_is_listed(ours: Outcome, real: Outcome) -> None:
    [complaint] = complaints([ours], [real], {})
    assert complaint.splitlines()[0] == 'f()'
    assert list(complaints([ours], [real], {'f()': str(ours)})) == []
    assert list(complaints([ours], [real], {'f()': 'something else'}))


def test_a_text_may_say_more() -> None:
    assert not list(
        complaints([raises('ValueError', text='too bad')], [raises('ValueError', text='bad\n')], {})
    )


def test_an_exception_derived_from_the_real_one_is_as_good() -> None:
    assert not list(
        complaints([raises('EncodeError', 'ValueError')], [raises('ValueError', 'Exception')], {})
    )


def test_a_text_that_goalwire_has_its_own_words_for_may_differ_but_not_the_type() -> None:
    real, texts = raises('TypeError', text='incompatible function arguments'), ['incompatible']
    assert not list(complaints([raises('TypeError')], [real], {}, texts))
    assert list(complaints([raises('ValueError')], [real], {}, texts))
    assert list(complaints([gives('None')], [real], {}, texts))


def test_a_listed_difference_that_is_gone_is_reported() -> None:
    assert list(complaints([gives('1')], [gives('1')], {'f()': '1'}))
    assert not list(complaints([gives('1')], [gives('1')], {'g()': '1'}))


def test_a_call_may_differ_at_one_of_its_places() -> None:
    both, once = [gives('1'), gives('1')], [gives('1'), gives('2')]
    assert not list(complaints(both, once, {'f()': '1'}))


def test_traces_of_other_calls_are_reported_with_the_calls() -> None:
    found = list(complaints([gives('1'), gives('2', 'g()')], [gives('1')], {}))
    assert found == ['g()\n  told under goalwire alone: 2']
    assert list(complaints([gives('1')], [gives('1'), gives('1')], {}))


def test_the_tracer_needs_nothing_but_python() -> None:
    source = TRACER.read_text()
    assert 'goalwire' not in source.partition('"""\n')[2]
    imported = {
        line.split()[1].split('.')[0] for line in source.splitlines() if line.startswith(('import ', 'from '))
    }
    assert imported <= sys.stdlib_module_names
