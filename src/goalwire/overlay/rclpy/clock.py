"""rclpy.clock: system, steady and ROS time."""

from goalwire.execution.clock import (
    Clock,
    ClockChange,
    JumpHandle,
    JumpThreshold,
    ROSClock,
    TimeJump,
)
from rclpy.clock_type import ClockType

__all__ = ['Clock', 'ClockChange', 'ClockType', 'JumpHandle', 'JumpThreshold', 'ROSClock', 'TimeJump']
