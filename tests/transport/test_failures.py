"""The log line of a receiver that failed."""

from __future__ import annotations

import pytest

from goalwire.transport.failures import report_failure


def test_a_failure_is_logged_with_its_place(caplog: pytest.LogCaptureFixture) -> None:
    report_failure("subscription '/chatter'", ZeroDivisionError('by zero'))
    (record,) = caplog.records
    assert record.name == 'goalwire.transport'
    assert record.levelname == 'ERROR'
    assert "subscription '/chatter'" in record.message
    assert 'ZeroDivisionError: by zero' in caplog.text
