"""Hands each record to the console and to the sinks, on the thread that logs, with no lock held."""

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
    """True while this thread is inside the sinks: lines that they log go to the console only."""

    active = False


class SinkHandle:
    """A registered sink; `close` ends it."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._failed = False

    def close(self) -> None:
        """Stop handing records to the sink. Idempotent."""
        global _sinks  # noqa: PLW0603 - emit() reads whatever tuple it finds, without a lock
        with _lock:
            _sinks = tuple(handle for handle in _sinks if handle is not self)

    def take(self, record: LogRecord) -> None:
        """Call the sink. Its first failure is reported on the console, others are ignored."""
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
    """Call `sink` with every record that is logged from now on, until the handle is closed.

    It is called on the thread that logs and should be quick. What it logs itself reaches the console only.
    """
    global _sinks  # noqa: PLW0603
    handle = SinkHandle(sink)
    with _lock:
        _sinks = (*_sinks, handle)
    return handle


def emit(record: LogRecord) -> None:
    """Hand one record to the handlers."""
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
    """Return the console, made from the environment when it is first wanted."""
    global _console  # noqa: PLW0603
    made = _console
    if made is not None:  # no lock, which in a forked child may be another thread's for ever
        return made
    with _lock:
        if _console is None:
            _console = Console.from_environment(os.environ)
        return _console


def set_console(*, enabled: bool) -> None:
    """Print records, or do not (`--disable-stdout-logs`)."""
    global _to_console  # noqa: PLW0603
    _to_console = enabled


def reset_console() -> None:
    """Read the environment again at the next record, and print."""
    global _console, _to_console  # noqa: PLW0603
    with _lock:
        _console = None
    _to_console = True


def _report_failure(sink: Sink, error: Exception) -> None:
    what = f'the log sink {sink!r} failed, later failures are not shown: {type(error).__name__}: {error}'
    console()(LogRecord(time.time_ns(), LoggingSeverity.ERROR, 'goalwire.logging', what, 'take', __file__, 0))
