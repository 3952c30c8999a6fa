"""launch.logging.handlers: handlers of Python's logging that `launch_config.log_handler_factory` may make."""

from logging import FileHandler, Handler, NullHandler, StreamHandler
from logging.handlers import (
    BaseRotatingHandler,
    BufferingHandler,
    DatagramHandler,
    HTTPHandler,
    MemoryHandler,
    NTEventLogHandler,
    QueueHandler,
    RotatingFileHandler,
    SMTPHandler,
    SocketHandler,
    SysLogHandler,
    TimedRotatingFileHandler,
    WatchedFileHandler,
)

__all__ = [
    'BaseRotatingHandler',
    'BufferingHandler',
    'DatagramHandler',
    'FileHandler',
    'HTTPHandler',
    'Handler',
    'MemoryHandler',
    'NTEventLogHandler',
    'NullHandler',
    'QueueHandler',
    'RotatingFileHandler',
    'SMTPHandler',
    'SocketHandler',
    'StreamHandler',
    'SysLogHandler',
    'TimedRotatingFileHandler',
    'WatchedFileHandler',
]
