from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from goalwire.logging import CallerId, LoggingSeverity, LogRecord, get_logging_severity_from_string
from goalwire.logging.record import DEFAULT_FORMAT, compile_format


def test_severities_carry_the_numbers_of_rcl_interfaces_log() -> None:
    assert {s.name: s.value for s in LoggingSeverity} == {
        'UNSET': 0,
        'DEBUG': 10,
        'INFO': 20,
        'WARN': 30,
        'ERROR': 40,
        'FATAL': 50,
    }


@pytest.mark.parametrize('text', ['info', 'INFO', 'Info'])
def test_a_severity_is_found_by_its_name_in_any_case(text: str) -> None:
    assert get_logging_severity_from_string(text) is LoggingSeverity.INFO


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RuntimeError, match=r"Failed to get severity name: 'warning' is not one of .*warn"):
        get_logging_severity_from_string('warning')


def test_a_caller_id_names_function_file_and_line_of_whoever_makes_it() -> None:
    caller = CallerId()
    assert caller.function_name == 'test_a_caller_id_names_function_file_and_line_of_whoever_makes_it'
    assert Path(caller.file_path) == Path(__file__)
    assert 'caller = CallerId()' in Path(__file__).read_text().splitlines()[caller.line_number - 1]


def test_two_calls_in_one_line_differ() -> None:
    first, second = CallerId(), CallerId()
    assert first.line_number == second.line_number
    assert first != second


def test_the_same_call_is_equal_each_time() -> None:
    assert len({CallerId() for _ in range(3)}) == 1


def test_a_frame_may_be_given() -> None:
    assert CallerId(sys._getframe(0)).function_name == 'test_a_frame_may_be_given'


def test_a_relative_file_name_is_made_absolute() -> None:
    names: dict[str, CallerId] = {}
    exec(compile('caller = CallerId()', 'typed_in', 'exec'), {'CallerId': CallerId}, names)
    assert Path(names['caller'].file_path) == Path.cwd() / 'typed_in'


RECORD = LogRecord(1795259849_733331772, LoggingSeverity.INFO, 'a.ln', 'hi', 'drive', '/src/base.py', 7)


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        (DEFAULT_FORMAT, '[INFO] [1795259849.733331772] [a.ln]: hi'),
        ('{function_name} {file_name}:{line_number}', 'drive /src/base.py:7'),
        ('{time_as_nanoseconds}', '1795259849733331772'),
        ('{message}{message', 'hi{message'),
        ('{unknown} {} }{ {{', '{unknown} {} }{ {{'),
        ('{{severity}|{ {name}}', '{INFO|{ a.ln}'),
        (r'\a\b\n\r\t\x1b[1m', '\a\b\n\r\t\x1b[1m'),
        (r'\e \q \\n \x1B', r'\e \q \\n \x1B'),
        ('\\', '\\'),
    ],
)
def test_a_format_is_filled_in(text: str, line: str) -> None:
    assert compile_format(text)(RECORD) == line


def test_braces_inside_a_message_stay_as_they_are() -> None:
    assert compile_format('{message}')(RECORD._replace(message='{name} %s \\n')) == '{name} %s \\n'


def test_times_near_zero_are_padded() -> None:
    early = RECORD._replace(stamp_ns=1_000_000_002)
    assert compile_format('{time} {time_as_nanoseconds}')(early) == '0000000001.000000002 0000000001000000002'


def test_the_date_has_milliseconds() -> None:
    assert re.fullmatch(r'2026-11-\d\d \d\d:\d\d:29\.733', compile_format('{date_time_with_ms}')(RECORD))
