"""rclpy.clock_type: the kinds of clocks."""

from goalwire.rules.time import ClockType
from rclpy._reexports import reexport

__all__ = ['ClockType']

reexport(__name__)
