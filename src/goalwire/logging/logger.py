"""The logger objects that programs use.

A call below the logger's level returns at once. Each other call is identified by its call site. A call site
has its own state of the filters, and must pass the same name, severity and filters at each call, as in ROS 2.
"""

from __future__ import annotations

import sys
import time
from typing import TypedDict, Unpack

from goalwire.errors import ChangedCallError, LoggerNameError
from goalwire.locks import ForkableLock
from goalwire.logging import dispatch
from goalwire.logging.filters import Context, LogClock, get_filters_from_kwargs, supported_filters
from goalwire.logging.levels import get_logger_effective_level, set_logger_level
from goalwire.logging.record import CallerId, LoggingSeverity, LogRecord

_DEBUG, _INFO, _WARN, _ERROR, _FATAL = list(LoggingSeverity)[1:]


class LogOptions(TypedDict, total=False):
    """The keyword arguments of a log call."""

    name: str
    once: bool
    skip_first: bool
    throttle_duration_sec: float
    throttle_time_source_type: LogClock


class RcutilsLogger:
    """Logs records under a name; dots in the name make a hierarchy of levels. '' is the root logger."""

    def __init__(self, name: str = '') -> None:
        self.name = name
        self.contexts: dict[CallerId, Context] = {}
        self.origin = name
        """The name of the first logger in the chain of get_child() calls that made this logger."""
        self._lock = ForkableLock()

    def get_child(self, name: str) -> RcutilsLogger:
        """Return the logger `<this name>.<name>`; raises ValueError for an empty name."""
        if not name:
            raise LoggerNameError('Child logger name must not be empty.')
        child = get_logger(f'{self.name}.{name}' if self.name else name)
        child.origin = self.origin or child.name
        return child

    def set_level(self, level: int) -> None:
        """Set the level of this logger and of its children; raises ValueError for an unknown severity."""
        set_logger_level(self.name, level)

    def get_effective_level(self) -> LoggingSeverity:
        """Return the level that applies to this logger, own or inherited."""
        return get_logger_effective_level(self.name)

    def is_enabled_for(self, severity: int) -> bool:
        """Tell whether a message of this severity would be logged; raises ValueError for an
        unknown severity.
        """
        return LoggingSeverity(severity) >= get_logger_effective_level(self.name)

    def log(self, message: str, severity: int, **kwargs: Unpack[LogOptions]) -> bool:
        """Log with a severity given as an argument; returns whether the message was logged.

        Raises TypeError for a message that is not a string or an unknown option, ValueError for a number that
        is not a severity, and for a call site that has passed another name, severity or filter before.
        """
        return self._log(LoggingSeverity(severity), message, kwargs)

    def debug(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a detail that helps to find a fault; see `log`."""
        return self._log(_DEBUG, message, kwargs)

    def info(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a normal event of the program; see `log`."""
        return self._log(_INFO, message, kwargs)

    def warning(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a sign of possible trouble; see `log`."""
        return self._log(_WARN, message, kwargs)

    def warn(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a sign of possible trouble; see `log`."""
        return self._log(_WARN, message, kwargs)

    def error(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a failure; see `log`."""
        return self._log(_ERROR, message, kwargs)

    def fatal(self, message: str, **kwargs: Unpack[LogOptions]) -> bool:
        """Log a failure that ends the program; see `log`."""
        return self._log(_FATAL, message, kwargs)

    def _log(self, severity: LoggingSeverity, message: str, options: LogOptions) -> bool:
        if severity < get_logger_effective_level(self.name):
            return False
        caller = CallerId(sys._getframe(2))  # the caller of info() or log()
        name = options.pop('name', self.name)
        with self._lock:
            if not self._passes(caller, name, severity, options):
                return False
        if name != self.name and severity < get_logger_effective_level(name):
            return False
        dispatch.emit(
            LogRecord(
                time.time_ns(),
                severity,
                name,
                message if type(message) is str else _text(message),
                caller.function_name,
                caller.file_path,
                caller.line_number,
                self.origin if name == self.name else name,
            )
        )
        return True

    def _passes(self, caller: CallerId, name: str, severity: LoggingSeverity, options: LogOptions) -> bool:
        """Return whether all filters of the call site let the call pass; they are asked in turn, up to the
        first refusal.
        """
        asked = get_filters_from_kwargs(**options) if options else []
        context = self.contexts.get(caller)
        if context is None:
            context = {'name': name, 'severity': severity, 'filters': asked}
            for filter_name in asked:
                supported_filters[filter_name].initialize_context(context, **options)
            self.contexts[caller] = context
        else:
            _refuse_change(context, name, severity, asked, options)
        return all(supported_filters[filter_name].should_log(context) for filter_name in asked)


def get_logger(name: str) -> RcutilsLogger:
    """Return a logger with this name; raises ValueError if the name is empty, TypeError if it is
    no string.
    """
    if not name:
        raise LoggerNameError('Logger name must not be empty.')
    if not isinstance(name, str):
        raise TypeError(f'Logger name must be a str, got {name!r}')
    return RcutilsLogger(name)


def _refuse_change(
    context: Context, name: str, severity: LoggingSeverity, asked: list[str], options: LogOptions
) -> None:
    if context['severity'] is not severity:
        raise ChangedCallError('Logger severity cannot be changed between calls.')
    if context['name'] != name:
        raise ChangedCallError('Logger name cannot be changed between calls.')
    if context['filters'] != asked:
        raise ChangedCallError('Requested logging filters cannot be changed between calls.')
    if asked and any(context[param] != value for param, value in options.items() if param in context):
        raise ChangedCallError('Logging filter parameters cannot be changed between calls.')


def _text(message: object) -> str:
    """Return the text that ROS 2 prints for a log message; raises TypeError if it is not a str, bytes or
    None.
    """
    if message is None:
        return '(null)'
    if isinstance(message, bytes):
        return message.decode(errors='backslashreplace')
    if isinstance(message, str):
        return str(message)
    raise TypeError(f'a log message must be a str, got {message!r}: write str(…) around it, or an f-string')
