from __future__ import annotations

import re

import pytest

from goalwire.logging import LoggingSeverity, LogRecord
from goalwire.logging.format import DEFAULT_FORMAT, compile_format

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
