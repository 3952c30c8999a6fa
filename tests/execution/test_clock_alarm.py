from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning, soon

from goalwire.execution.clock import Clock, ROSClock
from goalwire.execution.clock_alarm import ClockAlarm
from goalwire.execution.single_threaded import SingleThreadedExecutor
from goalwire.protocol.time import ClockType, Time

MS = 1_000_000


def ros(seconds: float) -> Time:
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


class Bell:
    """Counts its rings."""

    def __init__(self, clock: Clock, node: SmallNode) -> None:
        self.rings = 0
        self.rung = threading.Event()
        self.alarm = ClockAlarm(node.home, clock, self.ring)
        self.alarm.follow()

    def ring(self) -> None:
        self.rings += 1
        self.rung.set()


@pytest.fixture
def spinning(context: SmallContext) -> Iterator[SmallNode]:
    node = SmallNode()
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    with Spinning(executor):
        yield node


@pytest.mark.parametrize('kind', [ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME])
def test_an_alarm_rings_when_its_clock_shows_the_time(spinning: SmallNode, kind: ClockType) -> None:
    clock = Clock(clock_type=kind)
    bell = Bell(clock, spinning)
    due = clock.now_ns() + 20 * MS
    bell.alarm.set(due)
    assert soon(bell.rung)
    assert clock.now_ns() >= due - MS
    assert bell.alarm.remaining_ns() is None


def test_on_a_set_clock_it_rings_once_where_the_time_is_set() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    bell = Bell(clock, SmallNode())
    bell.alarm.set(2 * 10**9)
    assert bell.alarm.remaining_ns() == 2 * 10**9
    clock.set_ros_time_override(ros(1.9))
    assert bell.rings == 0
    for _ in range(3):
        clock.set_ros_time_override(ros(2))
    assert bell.rings == 1
    bell.alarm.set(10**9)
    assert bell.rings == 2, 'a time that is past rings at once'


def test_a_dropped_alarm_stays_silent() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    bell = Bell(clock, SmallNode())
    bell.alarm.set(10**9)
    bell.alarm.drop()
    clock.set_ros_time_override(ros(5))
    assert bell.rings == 0


def test_an_alarm_keeps_its_due_time_when_the_source_is_switched(spinning: SmallNode) -> None:
    clock = ROSClock()
    bell = Bell(clock, spinning)
    bell.alarm.set(clock.now_ns() + 3600 * 10**9)
    clock._set_ros_time_is_active(True)
    assert bell.rings == 0
    bell.alarm.set(10**9)
    clock._set_ros_time_is_active(False)
    assert soon(bell.rung), 'system time is past the first second of simulated time'
