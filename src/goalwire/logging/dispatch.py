"""Gives each record to the console and to the sinks, on the thread that logs, while it holds no lock."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self, TypeAlias

from goalwire.locks import ForkableLock
from goalwire.logging.console import Console
from goalwire.logging.record import LoggingSeverity, LogRecord

Sink: TypeAlias = Callable[[LogRecord], object]


class _Dispatching(threading.local):
    """`active` is True while this thread calls the sinks: lines that sinks log go only to the console."""

    active = False


class SinkHandle:
    """A registered sink; `close` removes it."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._failed = False

    def close(self) -> None:
        """Stop giving records to the sink. Idempotent."""
        global _sinks  # noqa: PLW0603 - emit() reads whatever tuple it finds, without a lock
        with _lock:
            _sinks = tuple(handle for handle in _sinks if handle is not self)

    def take(self, record: LogRecord) -> None:
        """Call the sink. The sink's first failure is reported on the console, later failures are ignored."""
        try:
            self._sink(record)
        except Exception as error:
            if not self._failed:
                self._failed = True
                _report_failure(self._sink, error)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


_lock = ForkableLock()
_sinks: tuple[SinkHandle, ...] = ()
_console: Console | None = None
_to_console = True
_dispatching = _Dispatching()


def add_sink(sink: Sink) -> SinkHandle:
    """Call `sink` with every record that is logged from now on, until the returned handle is closed.

    `sink` is called on the thread that logs and should be quick. Lines that it logs itself go only to the
    console.
    """
    global _sinks  # noqa: PLW0603
    handle = SinkHandle(sink)
    with _lock:
        _sinks = (*_sinks, handle)
    return handle


def emit(record: LogRecord) -> None:
    """Give one record to the console and to all sinks."""
    if _to_console:
        console()(record)
    if not _sinks or _dispatching.active:
        return
    _dispatching.active = True
    try:
        for handle in _sinks:
            handle.take(record)
    finally:
        _dispatching.active = False


def console() -> Console:
    """Return the console; the first call makes it from the environment variables."""
    global _console  # noqa: PLW0603
    made = _console
    if made is not None:  # without the lock, which another thread may hold during a fork
        return made
    with _lock:
        if _console is None:
            _console = Console.from_environment(os.environ)
        return _console


def set_console(*, enabled: bool) -> None:
    """Set whether records are printed on the console (`--disable-stdout-logs`)."""
    global _to_console  # noqa: PLW0603
    _to_console = enabled


def reset_console() -> None:
    """Print records from now on, and read the environment variables again at the next record."""
    global _console, _to_console  # noqa: PLW0603
    with _lock:
        _console = None
    _to_console = True


def _report_failure(sink: Sink, error: Exception) -> None:
    what = f'the log sink {sink!r} failed, later failures are not shown: {type(error).__name__}: {error}'
    console()(LogRecord(time.time_ns(), LoggingSeverity.ERROR, 'goalwire.logging', what, 'take', __file__, 0))
