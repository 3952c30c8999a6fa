"""rclpy.impl.logging_severity: how grave a log message is."""

from goalwire.logging.severity import LoggingSeverity
from rclpy._borrowed import borrow

__all__ = ['LoggingSeverity']

borrow(__name__)
