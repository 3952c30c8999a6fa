"""rclpy.clock_type: which clock an instant was read from."""

from goalwire.rules.time import ClockType
from rclpy._reexports import reexport

__all__ = ['ClockType']

reexport(__name__)
