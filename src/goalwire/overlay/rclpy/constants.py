"""rclpy.constants: seconds in nanoseconds."""

from goalwire.rules.time import S_TO_NS

__all__ = ['S_TO_NS']
