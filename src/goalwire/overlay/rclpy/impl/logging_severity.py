"""rclpy.impl.logging_severity: how grave a log message is."""

from goalwire.logging.severity import LoggingSeverity

__all__ = ['LoggingSeverity']
