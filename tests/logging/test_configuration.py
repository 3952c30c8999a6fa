from __future__ import annotations

from pathlib import Path

import pytest

from goalwire import logging
from goalwire.logging import LoggingSeverity as Severity
from goalwire.logging import get_logger, get_logger_effective_level


def test_configure_sets_levels_by_name() -> None:
    logging.configure([('', 10), ('q', 40)], to_console=True)
    assert get_logger_effective_level('any') is Severity.DEBUG
    assert get_logger_effective_level('q.child') is Severity.ERROR


def test_the_first_user_decides_until_the_last_one_leaves() -> None:
    logging.configure([('', 10)], to_console=True)
    logging.configure([('', 40)], to_console=True)
    assert get_logger_effective_level('a') is Severity.DEBUG
    logging.release()
    logging.release()
    logging.configure([('', 40)], to_console=True)
    assert get_logger_effective_level('a') is Severity.ERROR


def test_the_console_prints_again_once_the_last_user_has_left(capsys: pytest.CaptureFixture[str]) -> None:
    logging.configure([], to_console=False)
    logging.release()
    get_logger('a').info('x')
    assert capsys.readouterr().err.endswith('[a]: x\n')


def test_the_environment_is_read_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    logging.initialize()
    monkeypatch.setenv('RCUTILS_CONSOLE_OUTPUT_FORMAT', '{message}')
    logging.initialize()
    get_logger('a').info('x')
    assert capsys.readouterr().err.startswith('[INFO]')


def test_clear_config_forgets_levels_and_reads_the_environment_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    logging.configure([('a', 50)], to_console=False)
    monkeypatch.setenv('RCUTILS_CONSOLE_OUTPUT_FORMAT', '{message}')
    logging.clear_config()
    get_logger('a').info('x')
    assert capsys.readouterr().err == 'x\n'


def test_logging_goes_on_after_shutdown(capsys: pytest.CaptureFixture[str]) -> None:
    logging.shutdown()
    assert get_logger('a').info('x')
    assert '[a]: x' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('environment', 'expected'),
    [
        ({'ROS_LOG_DIR': '/logs', 'ROS_HOME': '/other'}, '/logs'),
        ({'ROS_HOME': '/robot'}, '/robot/log'),
        ({'ROS_LOG_DIR': '~/mine', 'HOME': '/home/me'}, '/home/me/mine'),
        ({'HOME': '/home/me'}, '/home/me/.ros/log'),
    ],
)
def test_log_files_belong_where_the_environment_says(
    environment: dict[str, str], expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ('ROS_LOG_DIR', 'ROS_HOME'):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert logging.get_logging_directory() == Path(expected)
