"""rclpy's names for time. Their behaviour is tested with goalwire.rules.time."""

from __future__ import annotations

from math import inf, nan

import pytest
from rclpy.clock_type import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration, Infinite
from rclpy.time import Time


def test_times_and_durations_work_together() -> None:
    later = Time(seconds=1, clock_type=ClockType.ROS_TIME) + Duration(seconds=0.5)
    assert later == Time(nanoseconds=3 * S_TO_NS // 2, clock_type=ClockType.ROS_TIME)
    assert later < Time(clock_type=ClockType.ROS_TIME) + Infinite


def test_durations_are_added_subtracted_and_multiplied_as_in_newer_rclpy() -> None:
    second, half = Duration(seconds=1), Duration(seconds=0.5)
    assert second + half == Duration(seconds=1.5)
    assert half - second == Duration(seconds=-0.5)
    assert second * 3 == Duration(seconds=3)
    assert second * 0.25 == Duration(nanoseconds=250_000_000)
    assert second * inf == Infinite
    assert Time(seconds=3) - (second + half) == Time(seconds=1.5)
    for factor in (nan, -inf):
        with pytest.raises(ValueError, match="Can't multiply duration with"):
            _ = second * factor
    for other in (1, '2', Time()):
        with pytest.raises(TypeError):
            _ = second - other  # type: ignore[operator]
    with pytest.raises(TypeError):
        _ = second + 1  # type: ignore[operator]
    with pytest.raises(TypeError):
        _ = second * '2'  # type: ignore[operator]
    for factor in (1e290, 2**63):
        with pytest.raises(OverflowError, match='too large to store in C duration'):
            _ = second * factor
    with pytest.raises(OverflowError, match='too large to store in C duration'):
        _ = Infinite + second
