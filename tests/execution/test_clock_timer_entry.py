from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import soon

from goalwire.execution.clock import Clock, ClockTimerEntry, ROSClock
from goalwire.execution.single_threaded import SingleThreadedExecutor
from goalwire.rules.time import ClockType, Time

MS = 1_000_000


def ros(seconds: float) -> Time:
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


class Bell:
    """Counts its rings."""

    def __init__(self, clock: Clock, node: SmallNode) -> None:
        self.rings = 0
        self.rung = threading.Event()
        self.alarm = ClockTimerEntry(node.work_queue, clock, self.ring)
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
    wake_fd = Bell(clock, spinning)
    due = clock.now_ns() + 20 * MS
    wake_fd.alarm.set(due)
    assert soon(wake_fd.rung)
    assert clock.now_ns() >= due - MS
    assert wake_fd.alarm.remaining_ns() is None


def test_on_a_set_clock_it_rings_once_where_the_time_is_set() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    wake_fd = Bell(clock, SmallNode())
    wake_fd.alarm.set(2 * 10**9)
    assert wake_fd.alarm.remaining_ns() == 2 * 10**9
    clock.set_ros_time_override(ros(1.9))
    assert wake_fd.rings == 0
    for _ in range(3):
        clock.set_ros_time_override(ros(2))
    assert wake_fd.rings == 1
    wake_fd.alarm.set(10**9)
    assert wake_fd.rings == 2, 'a time that is past rings at once'


def test_a_dropped_alarm_stays_silent() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    wake_fd = Bell(clock, SmallNode())
    wake_fd.alarm.set(10**9)
    wake_fd.alarm.drop()
    clock.set_ros_time_override(ros(5))
    assert wake_fd.rings == 0


def test_an_alarm_keeps_its_due_time_when_the_source_is_switched(spinning: SmallNode) -> None:
    clock = ROSClock()
    wake_fd = Bell(clock, spinning)
    wake_fd.alarm.set(clock.now_ns() + 3600 * 10**9)
    clock._set_ros_time_is_active(True)
    assert wake_fd.rings == 0
    wake_fd.alarm.set(10**9)
    clock._set_ros_time_is_active(False)
    assert soon(wake_fd.rung), 'system time is past the first second of simulated time'
