"""The log line of a receiver that failed."""

from __future__ import annotations

import pytest

from goalwire.transport.failures import report_failure


def test_a_failure_is_logged_with_its_place_and_traceback(caplog: pytest.LogCaptureFixture) -> None:
    try:
        raise ZeroDivisionError('by zero')
    except ZeroDivisionError as error:
        caught = error
    report_failure("subscription '/chatter'", caught)
    (record,) = caplog.records
    assert record.name == 'goalwire.transport'
    assert record.levelname == 'ERROR'
    assert "subscription '/chatter'" in record.message
    assert 'ZeroDivisionError: by zero' in caplog.text
