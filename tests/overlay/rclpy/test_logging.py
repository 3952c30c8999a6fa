"""rclpy's front of logging. Its behaviour is tested with goalwire.logging."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy.logging
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.impl import rcutils_logger
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger


@pytest.fixture(autouse=True)
def fresh_logging() -> Iterator[None]:
    rclpy.logging.clear_config()
    yield
    rclpy.logging.clear_config()


def test_loggers_are_rcutils_loggers(capsys: pytest.CaptureFixture[str]) -> None:
    logger = rclpy.logging.get_logger('a')
    assert type(logger) is RcutilsLogger
    assert logger.info('x')
    assert capsys.readouterr().err.endswith('[a]: x\n')


def test_levels_are_those_of_the_logger() -> None:
    rclpy.logging.set_logger_level('q', LoggingSeverity.ERROR, detailed_error=True)
    assert rclpy.logging.get_logger('q').get_effective_level() is LoggingSeverity.ERROR
    assert rclpy.logging.get_logger_level('q.c') is LoggingSeverity.UNSET
    assert rclpy.logging.get_logger_effective_level('q.c') is LoggingSeverity.ERROR


def test_severities_are_found_by_name() -> None:
    assert rclpy.logging.get_logging_severity_from_string('fatal') is LoggingSeverity.FATAL


def test_rclpys_clocks_throttle() -> None:
    logger = rclpy.logging.get_logger('a')
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    passed = [
        logger.info('x', throttle_duration_sec=3600.0, throttle_time_source_type=clock) for _ in range(2)
    ]
    assert passed == [True, False]


def test_the_filters_are_where_rclpy_has_them() -> None:
    assert rcutils_logger.get_filters_from_kwargs(once=True) == ['once']
    assert list(rcutils_logger.supported_filters.values()) == [
        rcutils_logger.Throttle,
        rcutils_logger.SkipFirst,
        rcutils_logger.Once,
    ]
