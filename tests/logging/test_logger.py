from __future__ import annotations

import sys
import threading
import time
from pathlib import Path

import pytest
from helpers.patience import PATIENCE

from goalwire.logging import LoggingSeverity as Severity
from goalwire.logging import LogRecord, RcutilsLogger, get_logger


def test_a_record_tells_who_said_what_when_and_where(records: list[LogRecord]) -> None:
    before = time.time_ns()
    assert get_logger('arm').warning('joint limit near')
    (record,) = records
    assert before <= record.stamp_ns <= time.time_ns()
    assert (record.severity, record.name, record.message) == (Severity.WARN, 'arm', 'joint limit near')
    assert record.function == 'test_a_record_tells_who_said_what_when_and_where'
    assert Path(record.file) == Path(__file__)
    assert "warning('joint limit near')" in Path(__file__).read_text().splitlines()[record.line - 1]


@pytest.mark.parametrize(
    ('method', 'severity'),
    [
        ('debug', Severity.DEBUG),
        ('info', Severity.INFO),
        ('warn', Severity.WARN),
        ('warning', Severity.WARN),
        ('error', Severity.ERROR),
        ('fatal', Severity.FATAL),
    ],
)
def test_each_method_logs_with_its_severity(
    method: str, severity: Severity, records: list[LogRecord]
) -> None:
    logger = get_logger('a')
    logger.set_level(Severity.DEBUG)
    assert getattr(logger, method)('x') is True
    assert [record.severity for record in records] == [severity]


@pytest.mark.parametrize('severity', [20, Severity.INFO])
def test_log_takes_the_severity_as_an_argument(severity: int, records: list[LogRecord]) -> None:
    assert get_logger('a').log('x', severity)
    assert records[0].severity is Severity.INFO


@pytest.mark.parametrize('severity', [25, 'INFO'])
def test_log_refuses_what_is_no_severity(severity: int) -> None:
    with pytest.raises(ValueError, match=f'{severity!r} is not a valid LoggingSeverity'):
        get_logger('a').log('x', severity)


def test_a_call_below_the_level_is_filtered_out(records: list[LogRecord]) -> None:
    assert get_logger('a').debug('x') is False
    assert records == []


def test_a_filtered_call_does_not_look_at_who_called(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(depth: int = 0) -> None:
        pytest.fail('the frame was inspected')

    logger = get_logger('a')
    monkeypatch.setattr(sys, '_getframe', refuse)
    passed = logger.debug('x', once=True)
    monkeypatch.undo()
    assert passed is False


def test_once_is_not_used_up_by_a_call_below_the_level() -> None:
    logger = get_logger('a')

    def say() -> bool:
        return logger.info('x', once=True)

    logger.set_level(Severity.ERROR)
    assert say() is False
    logger.set_level(Severity.INFO)
    assert [say(), say()] == [True, False]


def test_a_call_may_log_under_another_name(records: list[LogRecord]) -> None:
    assert get_logger('a').info('x', name='other')
    assert records[0].name == 'other'


def test_the_other_name_has_a_level_too(records: list[LogRecord]) -> None:
    get_logger('other').set_level(Severity.ERROR)
    assert get_logger('a').info('x', name='other') is False
    assert records == []


def test_children_are_named_after_their_parents() -> None:
    assert get_logger('p').get_child('c').name == 'p.c'
    assert RcutilsLogger().get_child('c').name == 'c'


def test_a_child_follows_the_level_of_its_parent() -> None:
    parent = get_logger('p')
    parent.set_level(Severity.ERROR)
    assert parent.get_child('c').get_effective_level() is Severity.ERROR
    assert parent.get_child('c').is_enabled_for(Severity.WARN) is False


def test_loggers_need_a_name() -> None:
    with pytest.raises(ValueError, match=r'Logger name must not be empty.'):
        get_logger('')
    with pytest.raises(ValueError, match=r'Child logger name must not be empty.'):
        get_logger('p').get_child('')


def test_a_logger_name_is_a_string() -> None:
    with pytest.raises(TypeError, match='Logger name must be a str, got 5'):
        get_logger(5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ('message', 'text'), [(None, '(null)'), (b'x\xff', 'x\\xff'), ('', ''), ('%s {}', '%s {}')]
)
def test_odd_messages_are_logged_as_ros_2_logs_them(
    message: str, text: str, records: list[LogRecord]
) -> None:
    assert get_logger('a').info(message)
    assert records[0].message == text


def test_a_message_that_is_no_text_is_refused() -> None:
    with pytest.raises(TypeError, match='a log message must be a str, got 5'):
        get_logger('a').info(5)  # type: ignore[arg-type]


def test_positional_arguments_are_refused_as_in_rclpy() -> None:
    with pytest.raises(
        TypeError, match=r'RcutilsLogger.info\(\) takes 2 positional arguments but 3 were given'
    ):
        get_logger('a').info('a %s', 'b')  # type: ignore[call-arg]


def log_twice(first: dict[str, object], second: dict[str, object]) -> None:
    logger = get_logger('a')
    for options in (first, second):
        logger.log('x', **{'severity': Severity.INFO, **options})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ('first', 'second', 'text'),
    [
        ({}, {'severity': Severity.WARN}, 'Logger severity cannot be changed between calls.'),
        ({}, {'name': 'b'}, 'Logger name cannot be changed between calls.'),
        ({}, {'once': True}, 'Requested logging filters cannot be changed between calls.'),
        (
            {'throttle_duration_sec': 1},
            {'throttle_duration_sec': 2},
            'Logging filter parameters cannot be changed between calls.',
        ),
    ],
)
def test_one_source_line_logs_in_one_way(
    first: dict[str, object], second: dict[str, object], text: str
) -> None:
    with pytest.raises(ValueError, match=text):
        log_twice(first, second)


def test_once_holds_among_threads(records: list[LogRecord]) -> None:
    logger = get_logger('a')
    barrier = threading.Barrier(8, timeout=PATIENCE)

    def say() -> None:
        barrier.wait()
        logger.info('x', once=True)

    threads = [threading.Thread(target=say) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(records) == 1


def test_a_childs_records_name_the_logger_that_it_descends_from(records: list[LogRecord]) -> None:
    logger = get_logger('a')
    logger.info('x')
    logger.get_child('b').get_child('c').info('x')
    logger.info('x', name='other')
    assert [(record.name, record.origin) for record in records] == [
        ('a', 'a'),
        ('a.b.c', 'a'),
        ('other', 'other'),
    ]
