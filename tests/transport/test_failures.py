"""The log lines of a receiver that failed."""

from __future__ import annotations

from goalwire.logging import LoggingSeverity, LogRecord
from goalwire.transport.failures import report_failure


def test_a_failure_is_logged_with_its_place(records: list[LogRecord]) -> None:
    report_failure("subscription '/chatter'", ZeroDivisionError('by zero'))
    (record,) = records
    assert record.name == 'goalwire.transport'
    assert record.severity is LoggingSeverity.ERROR
    assert "subscription '/chatter'" in record.message
    assert 'ZeroDivisionError: by zero' in record.message


def test_a_failure_that_comes_again_is_told_at_powers_of_ten(records: list[LogRecord]) -> None:
    for _ in range(150):
        report_failure('a', ZeroDivisionError())
    report_failure('b', ZeroDivisionError())
    report_failure('a', ValueError())
    firsts = [record.message.splitlines()[0].rpartition('; ')[2] for record in records]
    lost = 'this delivery is lost'
    assert firsts == [lost, f'{lost} (10 times by now)', f'{lost} (100 times by now)', lost, lost]
