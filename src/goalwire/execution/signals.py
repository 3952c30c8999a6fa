"""SIGINT and SIGTERM end the contexts (rclpy.signals), and uncaught exceptions end the program readably.

The handlers take no lock: they may interrupt the main thread anywhere. They end the registered shutdown
signals, which wakes every thread that waits under them. Then they call the handler that was installed before:
for SIGINT that is Python's own, which raises KeyboardInterrupt.

A listener thread ends the shutdown signals too, and earlier. Python runs handlers only in the main thread and
only between two steps of Python code. So a handler does not run while the main thread is in a call of the
system, like `time.sleep(20)` in a callback or the wait for a lock. The listener then interrupts that call: it
sends SIGURG, which means nothing to most programs, to the main thread until the handler has run.

An uncaught exception is printed with the program's own frames. Ctrl-C in a wait of ours ends the program
quietly. `init` installs the hooks for that, but only in place of Python's own: those of test runners,
debuggers and notebooks stay. The exit status is always Python's: that of Ctrl-C, and 1 after an exception.
"""

from __future__ import annotations

import atexit
import os
import select
import signal
import sys
import threading
from contextlib import suppress
from enum import Enum
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException, InvalidHandle
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.monotonic import STEADY
from goalwire.execution.waiting import LISTENING, WeakListeners
from goalwire.logging.tracebacks import is_library, is_standard, traceback_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType, TracebackType

    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.execution.waiting import ContextLike, ShutdownSignal

_CLOSE = 0
"""No signal has this number."""
_NUDGES_MS = (20, 200, 2000)
"""After so long each, the main thread is looked after that has not run a signal's handler."""
_EARLIER_NS = 10_000_000
"""How much before this thread has read of a signal its handler may have run."""


class SignalListener:
    """Calls `on_signal(number)` on its own thread for each signal that has a Python handler.

    It returns whether the main thread must run its handler soon, which says so by `noticed`. Python's C
    handler writes the numbers into a pipe (`signal.set_wakeup_fd`). Main thread only.
    """

    def __init__(self, on_signal: Callable[[int], bool]) -> None:
        self.main_thread = get_ident()
        self.wire_poller: WirePoller | None = None
        """The wait on the wire in which the main thread is, if it is: no signal reaches it there."""
        self._on_signal = on_signal
        self._process = os.getpid()
        self._reader, self._writer = os.pipe()
        if sys.platform != 'win32':
            os.set_blocking(self._writer, False)
        self._noticed_ns = 0
        self._nudges = sys.platform != 'win32' and signal.getsignal(signal.SIGURG) is signal.SIG_DFL
        if sys.platform != 'win32' and self._nudges:
            signal.signal(signal.SIGURG, _nothing)
        self._before = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        self._thread = threading.Thread(target=self._listen, name='goalwire-signals', daemon=True)
        self._thread.start()
        LISTENING.append(self)

    def hears(self) -> bool:
        """Whether signals come here; where an asyncio loop has given the pipe up, they do again."""
        owner = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        if owner in (self._writer, -1):
            return True
        signal.set_wakeup_fd(owner)
        return False

    def noticed(self) -> None:
        """The main thread runs a handler. Takes no lock."""
        self._noticed_ns = STEADY.now()

    def close(self) -> None:
        """Put back what was there before and end the thread."""
        with suppress(ValueError):
            LISTENING.remove(self)
        if sys.platform != 'win32' and self._nudges and signal.getsignal(signal.SIGURG) is _nothing:
            signal.signal(signal.SIGURG, signal.SIG_DFL)
        if os.getpid() != self._process:
            signal.set_wakeup_fd(-1)  # a forked child shares the pipe with its parent, and has no thread
            return
        current = signal.set_wakeup_fd(self._before)
        if current not in (self._writer, self._before):
            signal.set_wakeup_fd(current)  # an asyncio loop took over meanwhile
        os.write(self._writer, bytes([_CLOSE]))
        self._thread.join()
        os.close(self._writer)
        os.close(self._reader)

    def _listen(self) -> None:
        nudges: Iterator[int] = iter(())
        heard_ns = 0
        with suppress(OSError):
            while True:
                wait_ms = next(nudges, None)
                if wait_ms is not None and not self._has_more(wait_ms):
                    if self._noticed_ns < heard_ns - _EARLIER_NS:
                        self._nudge()
                    continue
                for number in os.read(self._reader, 64):
                    if number == _CLOSE:
                        return
                    if self._on_signal(number) and self._nudges:
                        nudges, heard_ns = iter(_NUDGES_MS), STEADY.now()
                    wire_poller = self.wire_poller
                    if wire_poller is not None:
                        wire_poller.interrupt()

    def _has_more(self, wait_ms: int) -> bool:
        """Whether something is written into the pipe within that time."""
        poll = select.poll()
        poll.register(self._reader, select.POLLIN)
        return bool(poll.poll(wait_ms))

    def _nudge(self) -> None:
        if sys.platform != 'win32':
            signal.pthread_kill(self.main_thread, signal.SIGURG)


def _nothing(_number: int, _frame: FrameType | None) -> None:
    """Handle SIGURG: to be interrupted by it is enough."""


class SignalHandlerOptions(Enum):
    """Which signals are handled."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_WANTED = {
    SignalHandlerOptions.NO: (),
    SignalHandlerOptions.SIGINT: (signal.SIGINT,),
    SignalHandlerOptions.SIGTERM: (signal.SIGTERM,),
    SignalHandlerOptions.ALL: (signal.SIGINT, signal.SIGTERM),
}
_ended: WeakListeners[ShutdownSignal] = WeakListeners()
_triggered: WeakListeners[GuardCondition] = WeakListeners()
_previous: dict[signal.Signals, Any] = {}
_listeners: list[SignalListener] = []
_came: set[int] = set()


def register(shutdown_signal: ShutdownSignal) -> None:
    """Make the handled signals end `shutdown_signal`, which is held weakly."""
    _ended.add(shutdown_signal)


def unregister(shutdown_signal: ShutdownSignal) -> None:
    """Signals no longer end `shutdown_signal`."""
    _ended.discard(shutdown_signal)


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Handle the signals of `options`, and no others. Does nothing outside the main thread.

    Raises TypeError for what is no SignalHandlerOptions.
    """
    if not isinstance(options, SignalHandlerOptions):
        raise TypeError(f'options must be SignalHandlerOptions, got {options!r}')
    if threading.current_thread() is not threading.main_thread():
        return
    uninstall_signal_handlers()
    for number in _WANTED[options]:
        _previous[number] = signal.signal(number, _handle)
    if _previous:
        _listeners.append(SignalListener(_on_signal))


def uninstall_signal_handlers() -> None:
    """Put back what was installed before. Does nothing outside the main thread."""
    if threading.current_thread() is not threading.main_thread():
        return
    while _listeners:
        _listeners.pop().close()
    while _previous:
        number, previous = _previous.popitem()
        if signal.getsignal(number) is _handle:
            signal.signal(number, signal.SIG_DFL if previous is None else previous)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Which signals are handled now."""
    handled = set(_previous)
    return next(options for options, wanted in _WANTED.items() if set(wanted) == handled)


def has_come() -> bool:
    """Whether a signal that is handled has come: it ends the program, unless the program has other plans."""
    return bool(_came)


class SignalHandlerGuardCondition(GuardCondition):
    """A guard condition that every handled signal triggers."""

    __slots__ = ()

    def __init__(self, context: ContextLike | None = None) -> None:
        super().__init__(None, None, context)
        _triggered.add(self)

    def destroy(self) -> None:
        _triggered.discard(self)
        super().destroy()


def is_ipython() -> bool:
    """Whether IPython or a notebook runs this program: Ctrl-C and Interrupt there end a cell, and no more."""
    get_ipython = getattr(sys.modules.get('IPython'), 'get_ipython', None)
    return get_ipython is not None and get_ipython() is not None


def _on_signal(number: int) -> bool:
    """End the contexts on the listener's thread. False for other signals, and if others handle it now.

    Whoever replaced our handler decides what the signal means: it may call ours, and may not.
    """
    if number not in _previous or signal.getsignal(number) is not _handle:
        return False
    _end_contexts(number)
    return True


def _end_contexts(number: int) -> None:
    _came.add(number)
    name = signal.Signals(number).name
    for shutdown_signal in _ended.alive():
        shutdown_signal.end(name)
    for guard in _triggered.alive():
        with suppress(InvalidHandle):
            guard.trigger()


def _handle(number: int, frame: FrameType | None) -> None:
    for listener in _listeners:
        listener.noticed()
    _end_contexts(number)
    previous = _previous.get(signal.Signals(number))
    if callable(previous):
        previous(number, frame)


def _reset_in_child() -> None:
    """After fork: signals to the child must not be written into the pipe that it shares with its parent."""
    while _listeners:
        _listeners.pop().close()


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_reset_in_child)
atexit.register(uninstall_signal_handlers)


def install_excepthooks() -> None:
    """Take over from Python's own hooks, where they are still Python's own: see the module."""
    if sys.excepthook is sys.__excepthook__:
        sys.excepthook = _excepthook
    if threading.excepthook is threading.__excepthook__:
        threading.excepthook = _thread_excepthook


def _excepthook(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    """Print what was not caught; nothing where Ctrl-C or SIGTERM ended a wait of ours."""
    if not _ended_a_wait(error.with_traceback(traceback)):
        _print(kind, error)
    if isinstance(error, KeyboardInterrupt):
        # Python remembers that Ctrl-C ends it, and forgets it when source is compiled and run, as modules
        # do that formatting a traceback imports. This reminds it, so that the exit status stays right.
        with suppress(KeyboardInterrupt):
            exec('raise KeyboardInterrupt')  # noqa: S102


def _thread_excepthook(arguments: threading.ExceptHookArgs) -> None:
    """Print what was not caught in a thread."""
    error = arguments.exc_value
    if error is None or isinstance(error, SystemExit):
        return
    if isinstance(error, ExternalShutdownException):
        return  # the program ends: so does what spins in its threads
    name = threading.current_thread().name if arguments.thread is None else arguments.thread.name
    _print(arguments.exc_type, error, f'Exception in thread {name}:\n')


def _print(kind: type[BaseException], error: BaseException, title: str = '') -> None:
    """Print in one piece: other threads log meanwhile."""
    if sys.stderr is None:
        return
    try:
        sys.stderr.write(f'{title}{traceback_text(error)}\n')
        sys.stderr.flush()
    except UnicodeEncodeError:
        sys.__excepthook__(kind, error, error.__traceback__)


def _ended_a_wait(error: BaseException) -> bool:
    """Whether a signal ended the program in a wait of the library, on the main thread."""
    if isinstance(error, ExternalShutdownException):
        return has_come()
    if not isinstance(error, KeyboardInterrupt):
        return False
    if _is_in_library(error):
        return True
    # asyncio.run() cancels what it runs, and raises KeyboardInterrupt in place of that.
    cancelled = error.__context__
    return (
        type(cancelled).__name__ == 'CancelledError' and cancelled is not None and _is_in_library(cancelled)
    )


def _is_in_library(error: BaseException) -> bool:
    """Whether the innermost frame is the library's, but for the signal's handler and Python's own waiting."""
    innermost = ''
    trace = error.__traceback__
    while trace is not None:
        filename = trace.tb_frame.f_code.co_filename
        if not is_standard(filename) and filename != __file__:
            innermost = filename
        trace = trace.tb_next
    return is_library(innermost)
