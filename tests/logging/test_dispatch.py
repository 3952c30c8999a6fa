from __future__ import annotations

import pytest

from goalwire.logging import LogRecord, add_sink, configure, get_logger


def test_every_sink_gets_every_record_that_passes() -> None:
    first: list[LogRecord] = []
    second: list[LogRecord] = []
    with add_sink(first.append), add_sink(second.append):
        get_logger('a').info('x')
        get_logger('a').debug('filtered')
    assert [record.message for record in first] == ['x']
    assert first == second


def test_a_closed_sink_gets_nothing_more() -> None:
    seen: list[LogRecord] = []
    handle = add_sink(seen.append)
    handle.close()
    handle.close()
    get_logger('a').info('x')
    assert seen == []


def test_a_record_cannot_be_changed(records: list[LogRecord]) -> None:
    get_logger('a').info('x')
    with pytest.raises(AttributeError):
        records[0].message = 'y'  # type: ignore[misc]


def test_a_sink_may_log_without_calling_itself(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[str] = []

    def sink(record: LogRecord) -> None:
        seen.append(record.message)
        get_logger('sink').info('from the sink')

    with add_sink(sink):
        get_logger('a').info('x')
    assert seen == ['x']
    assert '[sink]: from the sink' in capsys.readouterr().err


def test_a_failing_sink_is_reported_once_and_harms_nobody(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def broken(record: LogRecord) -> None:
        raise OSError('disk full')

    seen: list[LogRecord] = []
    with add_sink(broken), add_sink(seen.append):
        logger = get_logger('a')
        assert [logger.info('x') for _ in range(3)] == [True, True, True]
    assert len(seen) == 3
    assert capsys.readouterr().err.count('OSError: disk full') == 1


def test_sinks_still_get_what_the_console_does_not_print(
    records: list[LogRecord], capsys: pytest.CaptureFixture[str]
) -> None:
    configure([], to_console=False)
    assert get_logger('a').info('x') is True
    assert [record.message for record in records] == ['x']
    assert capsys.readouterr() == ('', '')
