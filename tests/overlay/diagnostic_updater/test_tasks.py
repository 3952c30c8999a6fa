"""Tasks that watch frequencies and stamps, and tasks made of others; time is virtual."""

from __future__ import annotations

import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import (
    CompositeDiagnosticTask,
    DiagnosticStatusWrapper,
    DiagnosticTask,
    FrequencyStatus,
    FrequencyStatusParam,
    FunctionDiagnosticTask,
    Heartbeat,
    SlowTimeStampStatus,
    TimeStampStatus,
    TimeStampStatusParam,
)
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.time import Time

from goalwire.testing import VirtualClock

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def judge(task: DiagnosticTask) -> DiagnosticStatusWrapper:
    return task.run(DiagnosticStatusWrapper())


def summary_of(status: DiagnosticStatus) -> tuple[bytes, str]:
    return status.level, status.message


def values_of(status: DiagnosticStatus) -> dict[str, str]:
    return {value.key: value.value for value in status.values}


@pytest.mark.parametrize(
    ('events', 'summary'),
    [
        (0, (ERROR, 'No events recorded.')),
        (8, (WARN, 'Frequency too low.')),
        (9, (OK, 'Desired frequency met')),
        (22, (OK, 'Desired frequency met')),
        (23, (WARN, 'Frequency too high.')),
    ],
)
def test_events_of_a_second_are_held_to_their_bounds(
    events: int, summary: tuple[bytes, str], gw_clock: VirtualClock
) -> None:
    frequency = FrequencyStatus(FrequencyStatusParam({'min': 10, 'max': 20}, tolerance=0.1))
    for _ in range(events):
        frequency.tick()
    time.sleep(1.0)  # virtual
    status = judge(frequency)
    assert summary_of(status) == summary
    assert values_of(status) == {
        'Events in window': str(events),
        'Events since startup': str(events),
        'Duration of window (s)': '1.000000',
        'Actual frequency (Hz)': f'{events:f}',
        'Minimum acceptable frequency (Hz)': '9.000000',
        'Maximum acceptable frequency (Hz)': '22.000000',
    }


def test_events_count_for_as_many_updates_as_the_window_has(gw_clock: VirtualClock) -> None:
    frequency = FrequencyStatus(FrequencyStatusParam({'min': 1}, window_size=2))
    frequency.tick()
    counted = []
    for _ in range(4):
        time.sleep(1.0)  # virtual
        counted.append(values_of(judge(frequency))['Events in window'])
    assert counted == ['1', '1', '0', '0']


def test_a_frequency_without_upper_bound_is_never_too_high(gw_clock: VirtualClock) -> None:
    frequency = FrequencyStatus(FrequencyStatusParam({'min': 0}))
    frequency.tick()
    status = judge(frequency)  # no time has passed: an infinite frequency
    assert status.level == OK
    assert 'Maximum acceptable frequency (Hz)' not in values_of(status)
    frequency.clear()
    assert summary_of(judge(frequency)) == (ERROR, 'No events recorded.')


@pytest.mark.parametrize(
    ('age', 'summary'),
    [
        (-2.0, (ERROR, 'Timestamps too far in future seen.')),
        (0.0, (OK, 'Timestamps are reasonable.')),
        (4.0, (OK, 'Timestamps are reasonable.')),
        (6.0, (ERROR, 'Timestamps too far in past seen.')),
    ],
)
@pytest.mark.parametrize('in_seconds', [True, False])
def test_stamps_are_held_to_their_ages(
    age: float, summary: tuple[bytes, str], in_seconds: bool, gw_clock: VirtualClock
) -> None:
    clock = Clock(clock_type=ClockType.ROS_TIME)
    stamp = clock.now() - Duration(seconds=age)
    stamps = TimeStampStatus(TimeStampStatusParam(min_acceptable=-1, max_acceptable=5), clock=clock)
    stamps.tick(stamp.nanoseconds / 1e9 if in_seconds else stamp)
    assert summary_of(judge(stamps)) == summary


def test_bad_stamps_are_reported_once_and_counted(gw_clock: VirtualClock) -> None:
    clock = Clock(clock_type=ClockType.ROS_TIME)
    stamps = TimeStampStatus(clock=clock)
    stamps.tick(clock.now())
    stamps.tick(Time(clock_type=ClockType.ROS_TIME))
    assert summary_of(judge(stamps)) == (ERROR, 'Zero timestamp seen.')
    stamps.tick(clock.now())
    status = judge(stamps)
    assert summary_of(status) == (OK, 'Timestamps are reasonable.')
    assert values_of(status)['Zero seen diagnostic update count:'] == '1'


@pytest.mark.parametrize(('kind', 'level'), [(TimeStampStatus, WARN), (SlowTimeStampStatus, OK)])
def test_no_stamps_are_a_warning_but_for_slow_events(kind: type[TimeStampStatus], level: bytes) -> None:
    assert summary_of(judge(kind())) == (level, 'No data since last update.')


def test_a_composite_has_the_values_of_all_and_the_merged_summary() -> None:
    def find_warm(stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        stat.summary(WARN, 'warm')
        stat.add('temperature', 61)
        return stat

    def find_hot(stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        assert stat.message == 'passed in', 'each task begins with the summary that was passed in'
        stat.summary(ERROR, 'hot')
        return stat

    composite = CompositeDiagnosticTask('motor')
    for task in (
        Heartbeat(),
        FunctionDiagnosticTask('left', find_warm),
        FunctionDiagnosticTask('right', find_hot),
    ):
        composite.addTask(task)
    status = composite.run(DiagnosticStatusWrapper(message='passed in'))
    assert composite.getName() == 'motor'
    assert summary_of(status) == (ERROR, 'warm; hot')
    assert values_of(status) == {'temperature': '61'}
