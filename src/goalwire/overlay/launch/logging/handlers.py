"""launch.logging.handlers: the handlers of Python's logging, for `launch_config.log_handler_factory`."""

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
