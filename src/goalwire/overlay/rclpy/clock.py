"""rclpy.clock: the clocks for system time, steady time and ROS time."""

from goalwire.execution.time.clock import (
    Clock,
    ClockChange,
    JumpHandle,
    JumpThreshold,
    ROSClock,
    TimeJump,
    TimeJumpDictionary,
)
from rclpy._reexports import reexport
from rclpy.clock_type import ClockType

__all__ = [
    'Clock',
    'ClockChange',
    'ClockHandle',
    'ClockType',
    'JumpHandle',
    'JumpThreshold',
    'ROSClock',
    'TimeJump',
    'TimeJumpDictionary',
]

ClockHandle = Clock
"""The type of `Clock.handle`, which stands in for rclpy's C clock."""

reexport(__name__)
