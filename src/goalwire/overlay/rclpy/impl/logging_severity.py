"""rclpy.impl.logging_severity: the severity of a log message."""

from goalwire.logging.record import LoggingSeverity
from rclpy._reexports import reexport

__all__ = ['LoggingSeverity']

reexport(__name__)
