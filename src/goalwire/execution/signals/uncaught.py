"""Uncaught exceptions end the program with a readable traceback.

An uncaught exception is printed with the program's own frames. Ctrl-C in a wait of goalwire ends the program
quietly. `init` installs hooks for that, but only in place of Python's own hooks: those of test runners,
debuggers and notebooks stay. The exit status is always Python's: that of Ctrl-C, or 1 after an exception.
"""

from __future__ import annotations

import sys
import threading
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.concurrency import exits
from goalwire.errors import ClosedError, ExternalShutdownException
from goalwire.execution.signals import signal_handlers
from goalwire.tracebacks import excepthook, is_library, is_standard, show_uncaught

if TYPE_CHECKING:
    from types import TracebackType


def install_excepthooks() -> None:
    """Replace Python's own hooks, unless a program has replaced them: see the module."""
    if sys.excepthook in {sys.__excepthook__, excepthook}:
        sys.excepthook = _excepthook
    if threading.excepthook is threading.__excepthook__:
        threading.excepthook = _thread_excepthook


def _excepthook(_kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    """Print an uncaught exception; print nothing if Ctrl-C or SIGTERM ended a wait of this library."""
    if not _ended_a_wait(error.with_traceback(traceback)):
        show_uncaught(error)
    if isinstance(error, KeyboardInterrupt):
        # Python keeps a flag that Ctrl-C ends the program, for the exit status. Compiling and running source
        # clears it, and the formatting of a traceback imports modules. This line sets the flag again.
        with suppress(KeyboardInterrupt):
            exec('raise KeyboardInterrupt')  # noqa: S102


def _thread_excepthook(arguments: threading.ExceptHookArgs) -> None:
    """Print a thread's uncaught exception."""
    error = arguments.exc_value
    if error is None or isinstance(error, SystemExit):
        return
    if isinstance(error, ExternalShutdownException):
        return  # not printed: the end of the program has ended this thread's spin
    if isinstance(error, ClosedError) and exits.has_begun():
        return  # not printed: at the program's end a callback has used a closed entity
    name = threading.current_thread().name if arguments.thread is None else arguments.thread.name
    show_uncaught(error, f'Exception in thread {name}:\n')


def _ended_a_wait(error: BaseException) -> bool:
    """Tell whether a signal ended the program while the main thread was in a wait of the library."""
    if isinstance(error, ExternalShutdownException):
        return signal_handlers.has_come()
    if not isinstance(error, KeyboardInterrupt):
        return False
    if _is_in_library(error):
        return True
    # On Ctrl-C asyncio.run() cancels its task, and raises KeyboardInterrupt in place of the CancelledError.
    cancelled = error.__context__
    return (
        type(cancelled).__name__ == 'CancelledError' and cancelled is not None and _is_in_library(cancelled)
    )


def _is_in_library(error: BaseException) -> bool:
    """Tell whether the innermost frame, without those of signal handlers and Python's waits, is the
    library's.
    """
    innermost = ''
    trace = error.__traceback__
    while trace is not None:
        filename = trace.tb_frame.f_code.co_filename
        if not is_standard(filename) and filename != signal_handlers.__file__:
            innermost = filename
        trace = trace.tb_next
    return is_library(innermost)
