"""Log records (severity, text, call site), and the format in which they become lines on the console.

Severities have the numbers of rcl_interfaces/msg/Log; RCUTILS_CONSOLE_OUTPUT_FORMAT sets the line's format
(rcutils/logging.h).
"""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable
from enum import IntEnum
from functools import lru_cache
from types import FrameType
from typing import NamedTuple, Self

from goalwire.errors import UnknownSeverityError
from goalwire.patterns import Pattern


class LoggingSeverity(IntEnum):
    """The severity of a message, or the lowest severity that a logger lets pass; UNSET: the logger inherits
    its level.
    """

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity with this name, in upper or lower case; raises UnknownSeverityError (a
    RuntimeError).
    """
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        known = ', '.join(member.name.lower() for member in LoggingSeverity)
        raise UnknownSeverityError(
            f"Failed to get severity name: '{log_severity}' is not one of {known}"
        ) from None


class _CallSite(NamedTuple):
    function_name: str
    file_path: str
    line_number: int
    last_index: int
    """The offset of the call in the bytecode, which distinguishes two calls in one line."""


class CallerId(_CallSite):
    """The call site that `frame` is executing; by default the place where CallerId() is called."""

    __slots__ = ()

    def __new__(cls, frame: FrameType | None = None) -> Self:
        frame = frame or sys._getframe(1)  # not by inspect: its import takes milliseconds
        code = frame.f_code
        return super().__new__(cls, code.co_name, _full_path(code.co_filename), frame.f_lineno, frame.f_lasti)


@lru_cache(maxsize=1024)
def _full_path(filename: str) -> str:
    return os.path.abspath(filename)  # noqa: PTH100 - links are left as they are


class LogRecord(NamedTuple):
    """A log record: its text, time (ns since the UNIX epoch), logger and source line."""

    stamp_ns: int
    severity: LoggingSeverity
    name: str
    message: str
    function: str
    file: str
    line: int
    origin: str = ''
    """The name of the logger at the root of the get_child() chain: usually the node's, whose records go to
    /rosout.
    """


DEFAULT_FORMAT = '[{severity}] [{time}] [{name}]: {message}'

Formatter = Callable[[LogRecord], str]

_ESCAPES = {'a': '\a', 'b': '\b', 'n': '\n', 'r': '\r', 't': '\t', 'x1b': '\x1b'}


def _seconds(record: LogRecord) -> str:
    seconds, nanoseconds = divmod(record.stamp_ns, 1_000_000_000)
    return f'{seconds:010d}.{nanoseconds:09d}'


def local_date_time(stamp_ns: int) -> str:
    """Return a time in ns since 1970 as text: local date and time, with milliseconds."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    local = time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(seconds))
    return f'{local}.{nanoseconds // 1_000_000:03d}'


_TOKENS: dict[str, Formatter] = {
    'severity': lambda record: record.severity.name,
    'name': lambda record: record.name,
    'message': lambda record: record.message,
    'function_name': lambda record: record.function,
    'file_name': lambda record: record.file,
    'line_number': lambda record: str(record.line),
    'time': _seconds,
    'time_as_nanoseconds': lambda record: f'{record.stamp_ns:019d}',
    'date_time_with_ms': lambda record: local_date_time(record.stamp_ns),
}
# A backslash and the character behind it are matched together, so that `\\n` stays as it is written.
_PART = Pattern(r'(\{(?:' + '|'.join(_TOKENS) + r')\})|(\\(?:x1b|.))', re.DOTALL)


def compile_format(text: str) -> Formatter:
    """Return a function that formats a record as `text` says. Unknown tokens stay in the line."""
    parts: list[str | Formatter] = []
    end = 0
    for found in _PART.finditer(text):
        parts.append(text[end : found.start()])
        token, escape = found[1], found[2]
        parts.append(_TOKENS[token[1:-1]] if token else _ESCAPES.get(escape[1:], escape))
        end = found.end()
    parts.append(text[end:])

    def line(record: LogRecord) -> str:
        return ''.join([part if isinstance(part, str) else part(record) for part in parts])

    return line
