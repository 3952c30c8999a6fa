"""ROS 2's logging: named loggers with inherited levels, filters for each call site, ROS 2's console format.

A log call first passes the module `logger` (level, filters, call site). Then it becomes an immutable
`LogRecord`, which `dispatch` gives to the console and to each sink that `add_sink` has registered (rosout,
log files).
"""

from goalwire.logging.configuration import (
    clear_config,
    configure,
    get_logging_directory,
    initialize,
    release,
    shutdown,
)
from goalwire.logging.dispatch import Sink, SinkHandle, add_sink
from goalwire.logging.levels import get_logger_effective_level, get_logger_level, set_logger_level
from goalwire.logging.logger import RcutilsLogger, get_logger
from goalwire.logging.record import CallerId, LoggingSeverity, LogRecord, get_logging_severity_from_string

__all__ = [
    'CallerId',
    'LogRecord',
    'LoggingSeverity',
    'RcutilsLogger',
    'Sink',
    'SinkHandle',
    'add_sink',
    'clear_config',
    'configure',
    'get_logger',
    'get_logger_effective_level',
    'get_logger_level',
    'get_logging_directory',
    'get_logging_severity_from_string',
    'initialize',
    'release',
    'set_logger_level',
    'shutdown',
]
