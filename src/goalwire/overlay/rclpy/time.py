"""rclpy.time: instants."""

from goalwire.rules.time import Time
from rclpy._reexports import reexport
from rclpy.clock_type import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration

__all__ = ['S_TO_NS', 'ClockType', 'Duration', 'Time', 'TimeHandle']

TimeHandle = Time
"""The type of `Time.handle`, which is the Time itself, since there is no C object."""

reexport(__name__)
