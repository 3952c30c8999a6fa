"""rclpy.clock_type: which clock an instant was read from."""

from goalwire.protocol.time import ClockType

__all__ = ['ClockType']
