"""rclpy.impl.logging_severity: how grave a log message is."""

from goalwire.logging.record import LoggingSeverity
from rclpy._reexports import reexport

__all__ = ['LoggingSeverity']

reexport(__name__)
