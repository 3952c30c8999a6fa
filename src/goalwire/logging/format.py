"""The console's line format, RCUTILS_CONSOLE_OUTPUT_FORMAT (rcutils/logging.h)."""

from __future__ import annotations

import re
import time
from collections.abc import Callable

from goalwire.logging.record import LogRecord

DEFAULT_FORMAT = '[{severity}] [{time}] [{name}]: {message}'

Formatter = Callable[[LogRecord], str]

_ESCAPES = {'a': '\a', 'b': '\b', 'n': '\n', 'r': '\r', 't': '\t', 'x1b': '\x1b'}


def _seconds(record: LogRecord) -> str:
    seconds, nanoseconds = divmod(record.stamp_ns, 1_000_000_000)
    return f'{seconds:010d}.{nanoseconds:09d}'


def _date_time(record: LogRecord) -> str:
    seconds, nanoseconds = divmod(record.stamp_ns, 1_000_000_000)
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
    'date_time_with_ms': _date_time,
}
# A backslash and what follows it are read together, so that `\\n` stays as it is written.
_PART = re.compile(r'(\{(?:' + '|'.join(_TOKENS) + r')\})|(\\(?:x1b|.))', re.DOTALL)


def compile_format(text: str) -> Formatter:
    """Return a function that writes records in this format; what it does not know stays as it is."""
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
