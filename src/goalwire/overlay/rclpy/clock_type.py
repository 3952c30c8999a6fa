"""rclpy.clock_type: which clock an instant was read from."""

from goalwire.rules.time import ClockType
from rclpy._borrowed import borrow

__all__ = ['ClockType']

borrow(__name__)
