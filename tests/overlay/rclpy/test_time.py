"""rclpy's names for time. Their behaviour is tested with goalwire.protocol.time."""

from __future__ import annotations

from rclpy.clock_type import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration, Infinite
from rclpy.time import Time


def test_times_and_durations_work_together() -> None:
    later = Time(seconds=1, clock_type=ClockType.ROS_TIME) + Duration(seconds=0.5)
    assert later == Time(nanoseconds=3 * S_TO_NS // 2, clock_type=ClockType.ROS_TIME)
    assert later < Time(clock_type=ClockType.ROS_TIME) + Infinite
