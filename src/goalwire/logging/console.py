"""Writes records as lines to stderr or stdout, as the RCUTILS_* variables say (rcutils/logging.h)."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import Self, TextIO

from goalwire.locks import ForkableLock
from goalwire.logging.record import DEFAULT_FORMAT, Formatter, LoggingSeverity, LogRecord, compile_format

_COLOURS = {
    LoggingSeverity.DEBUG: '\x1b[32m',
    LoggingSeverity.INFO: '\x1b[0m',
    LoggingSeverity.WARN: '\x1b[33m',
    LoggingSeverity.ERROR: '\x1b[31m',
    LoggingSeverity.FATAL: '\x1b[31m',
}
_NO_COLOUR = '\x1b[0m'

# One lock for all consoles, held only during write and flush, so that lines stay whole. It is re-entrant
# because a signal handler may log while the same thread is writing.
_writing = ForkableLock()


class Console:
    """A sink that prints. Each line goes to the present sys.stderr or sys.stdout, since programs replace
    these.
    """

    def __init__(
        self,
        formatter: Formatter,
        *,
        to_stdout: bool = False,
        flush: bool = True,
        colours: bool | None = None,
    ) -> None:
        """With None for `colours`, lines are coloured if the stream is a terminal."""
        self.format = formatter
        self._to_stdout = to_stdout
        self._flush = flush
        self._colours = colours

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Self:
        """Make a console from the RCUTILS_* variables; a value that ROS 2 does not know is reported and
        ignored.
        """
        to_stdout = _switch(environment, 'RCUTILS_LOGGING_USE_STDOUT') or False
        buffered = _switch(environment, 'RCUTILS_LOGGING_BUFFERED_STREAM')
        return cls(
            compile_format(environment.get('RCUTILS_CONSOLE_OUTPUT_FORMAT') or DEFAULT_FORMAT),
            to_stdout=to_stdout,
            # If the variable is unset, stderr is flushed after each line, and stdout is buffered as Python
            # does it.
            flush=buffered is not None or not to_stdout,
            colours=_switch(environment, 'RCUTILS_COLORIZED_OUTPUT'),
        )

    def __call__(self, record: LogRecord) -> None:
        """Print one record. If the stream is closed or broken, nothing is printed and no error is raised."""
        stream = sys.stdout if self._to_stdout else sys.stderr
        if stream is None:  # pythonw and some daemons have no stderr
            return
        try:
            line = self.format(record)
            if self._wants_colours(stream):
                line = f'{_COLOURS.get(record.severity, _NO_COLOUR)}{line}{_NO_COLOUR}'
            with _writing:
                _write(stream, f'{line}\n')
                if self._flush:
                    stream.flush()
        except (OSError, ValueError, RuntimeError):
            return

    def _wants_colours(self, stream: TextIO) -> bool:
        if self._colours is not None:
            return self._colours
        # The old console of Windows does not interpret escape sequences.
        return stream.isatty() and (os.name != 'nt' or 'WT_SESSION' in os.environ)


def _write(stream: TextIO, text: str) -> None:
    try:
        stream.write(text)
    except UnicodeEncodeError:
        encoding = getattr(stream, 'encoding', None) or 'ascii'
        stream.write(text.encode(encoding, 'backslashreplace').decode(encoding))


def _switch(environment: Mapping[str, str], name: str) -> bool | None:
    """Return True for a variable with '1', False for '0'; None if it is unset, empty or has another value."""
    value = environment.get(name, '')
    if value in ('0', '1'):
        return value == '1'
    if value and sys.stderr is not None:
        sys.stderr.write(f"goalwire: {name} is '{value}', which is ignored: set it to 0 or 1\n")
    return None
