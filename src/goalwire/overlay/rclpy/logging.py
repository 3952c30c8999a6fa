"""rclpy.logging: loggers by name, and the level of each logger."""

from goalwire.logging import (
    LoggingSeverity,
    RcutilsLogger,
    clear_config,
    get_logger,
    get_logger_effective_level,
    get_logger_level,
    get_logging_directory,
    get_logging_severity_from_string,
    initialize,
    set_logger_level,
    shutdown,
)
from rclpy._reexports import reexport

__all__ = [
    'LoggingSeverity',
    'RcutilsLogger',
    'clear_config',
    'get_logger',
    'get_logger_effective_level',
    'get_logger_level',
    'get_logging_directory',
    'get_logging_severity_from_string',
    'initialize',
    'set_logger_level',
    'shutdown',
]

_root_logger = RcutilsLogger()

reexport(__name__)
