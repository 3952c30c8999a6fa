"""rclpy.constants: the number of nanoseconds in a second."""

from goalwire.rules.time import S_TO_NS

__all__ = ['S_TO_NS']
