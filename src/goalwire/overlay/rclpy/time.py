"""rclpy.time: instants."""

from goalwire.protocol.time import Time
from rclpy.clock_type import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration

__all__ = ['S_TO_NS', 'ClockType', 'Duration', 'Time']
