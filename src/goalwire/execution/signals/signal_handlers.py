"""SIGINT and SIGTERM end the contexts (rclpy.signals).

The rule: the main thread decides. It runs our handler, which ends the registered shutdown signals and so
wakes every thread that waits under them. Then it calls the handler that was installed before: for SIGINT that
is Python's own, which raises KeyboardInterrupt. The handler takes no lock: it may interrupt the main thread
anywhere. A handler that the program installs later replaces ours: it runs at once, and nothing of ours ends.

Python runs handlers only in the main thread and only between two bytecode instructions. So a listener thread
reads the numbers of all signals that come (signal_pipe.py) and helps:

- If the main thread waits in the wire's library, the listener ends that wait.
- If the main thread has run no handler for a while, it may have begun a call of the system just before the
  signal came. The listener interrupts that call by SIGURG, which means nothing to most programs.
- If the main thread does not answer that either, it is in a call of C that may last, like the loop of a
  window system. Then the listener ends the contexts in its place, if our handler is the one to run.

A forked child gets the handlers back that were installed before ours, until it opens a context of its own.
During the fork all signals are blocked, since the child at first shares the pipe with its parent.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from contextlib import suppress
from enum import Enum
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.concurrency.exits import Stage, at_exit
from goalwire.concurrency.threads import begin, join_begun
from goalwire.errors import InvalidHandle
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.signals.signal_pipe import is_pipe_open, signal_pipe
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.waiters import LISTENING
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from types import FrameType

    from goalwire.concurrency.wire_poller import WirePoller
    from goalwire.execution.shutdown_signal import ContextLike, ShutdownSignal

_CLOSE = 0
"""The byte that ends the listener's thread. No signal has the number 0."""
_ASKED_AT_NS = (20_000_000, 100_000_000, 400_000_000, 2_400_000_000)
"""The times in ns after a signal at which SIGURG is sent to the main thread, if it has run no
handler since.
"""
_MUTE_AT = 1
"""The index of the time at which the contexts are ended if the main thread has not answered by then."""
_EARLIER_NS = 10_000_000
"""The time in ns by which the main thread may run a signal's handler before the listener reads the number."""


class SignalListener:
    """Reads the numbers of all signals on a thread of its own, and wakes the main thread for the signals that
    goalwire handles.

    `is_ours(number)` says whether our handler is the one to run. `end_unless(answered, number)` ends the
    contexts in the main thread's place, unless that thread has answered meanwhile. Main thread only.
    """

    def __init__(
        self, is_ours: Callable[[int], bool], end_unless: Callable[[Callable[[], bool], int], None]
    ) -> None:
        self.main_thread = get_ident()
        self.wire_poller: WirePoller | None = None
        """The wire on which the main thread waits, if it does. No signal's handler can run
        during that wait.
        """
        self._is_ours = is_ours
        self._end_unless = end_unless
        self._pipe = signal_pipe()
        self._unanswered: set[int] = set()
        """The handled signals for which the main thread is not known to have run a handler yet."""
        self._heard_ns = self._noticed_ns = 0
        self._asked = 0
        """The number of times that `_ask` was called since the last handled signal."""
        self._nudges = sys.platform != 'win32' and signal.getsignal(signal.SIGURG) is signal.SIG_DFL
        if sys.platform != 'win32' and self._nudges:
            signal.signal(signal.SIGURG, _answer)
        self._pipe.take()
        self._thread = threading.Thread(target=self._listen, name='goalwire-signals', daemon=True)
        begin(self._thread)
        LISTENING.append(self)

    def hears(self) -> bool:
        """Tell whether Python writes the numbers of signals into this listener's pipe. If the wake-up
        descriptor is free, take it back first.
        """
        return self._pipe.take_if_free()

    def notice(self) -> None:
        """Note that the main thread runs a handler now. Takes no lock."""
        self._noticed_ns = STEADY.now()

    def close(self) -> bool:
        """Restore the wake-up descriptor that was set before.

        Return False if the listener's thread must go on, since it passes signals on to that descriptor.
        """
        with suppress(ValueError):
            LISTENING.remove(self)
        if sys.platform != 'win32' and self._nudges and signal.getsignal(signal.SIGURG) is _answer:
            signal.signal(signal.SIGURG, signal.SIG_DFL)
        return self._pipe.give_back()

    def end_thread(self) -> None:
        """End the thread, and wait until it has ended."""
        if self._pipe.write(_CLOSE):
            join_begun(self._thread)

    # -- on the listener's thread

    def _listen(self) -> None:
        # Each number first goes to the descriptor that was installed before, then counts as a handled signal,
        # if goalwire's handler is installed. The wait on the wire is ended for every signal, since the
        # program may have handlers of its own.
        if sys.platform != 'win32':
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})  # `pass_on` may write to a closed pipe
        with suppress(OSError):
            while True:
                if self._unanswered and not self._has_more():
                    self._ask()
                    continue
                numbers = os.read(self._pipe.reader, 64)
                if _CLOSE in numbers:
                    return
                self._pipe.pass_on(numbers)
                ours = set(filter(self._is_ours, numbers))
                if ours:
                    self._unanswered |= ours
                    self._heard_ns, self._asked = STEADY.now(), 0
                wire_poller = self.wire_poller
                if wire_poller is not None:
                    wire_poller.interrupt()

    def _has_more(self) -> bool:
        """Wait until the pipe has the number of a signal, or the next SIGURG to the main thread is due.

        Return True if there is a number.
        """
        if sys.platform == 'win32':
            return False
        left_ns = self._heard_ns + _ASKED_AT_NS[self._asked] - STEADY.now()
        poll = select.poll()
        poll.register(self._pipe.reader, select.POLLIN)
        return bool(poll.poll(max(left_ns, 0) / 1e6))

    def _ask(self) -> None:
        """Send SIGURG to the main thread if it has run no handler; at the time _MUTE_AT end the contexts
        first.
        """
        if sys.platform == 'win32' or self._asked == _MUTE_AT:
            for number in self._unanswered:
                self._end_unless(self._has_answered, number)
        if not self._has_answered() and self._nudges and sys.platform != 'win32':
            signal.pthread_kill(self.main_thread, signal.SIGURG)
        self._asked += 1
        if self._has_answered() or self._asked == len(_ASKED_AT_NS) or sys.platform == 'win32':
            self._unanswered.clear()

    def _has_answered(self) -> bool:
        return self._noticed_ns >= self._heard_ns - _EARLIER_NS


def _answer(_number: int, _frame: FrameType | None) -> None:
    """Handle SIGURG, as the sign that the main thread runs handlers.

    Python runs the handlers of lower numbers first, so those of SIGINT and SIGTERM have run by then.
    """
    for listener in _listeners:
        listener.notice()


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


class _Handler:
    """Ends the contexts, then calls the handler that was installed before it.

    It compares equal to that handler, if that is a function. Some libraries, such as trio, install their own
    handler only if the present one equals Python's default; they still do so with this one in its place.
    """

    __slots__ = ('previous',)

    def __init__(self, previous: Any) -> None:
        self.previous = previous
        """The handler that `signal.getsignal` returned; None if no Python code has installed it."""

    def __call__(self, number: int, frame: FrameType | None) -> None:
        # The listener is notified first, so that it does not end the contexts in the main thread's place. The
        # previous handler comes last, since it may raise, as Python's own does for SIGINT.
        for listener in _listeners:
            listener.notice()
        _end(_ended.alive(), number)
        if callable(self.previous):
            self.previous(number, frame)

    def __eq__(self, other: object) -> bool:
        return other is self or (callable(self.previous) and other == self.previous)

    def __hash__(self) -> int:
        return hash(self.previous) if callable(self.previous) else id(self)

    def is_installed(self, number: int) -> bool:
        """Tell whether this is the installed handler of `number`, so no other has replaced it."""
        return signal.getsignal(number) is self

    def uninstall(self, number: int) -> None:
        """Install the previous handler again, unless this handler was replaced."""
        if self.is_installed(number):
            signal.signal(number, signal.SIG_DFL if self.previous is None else self.previous)


_ended: WeakMembers[ShutdownSignal] = WeakMembers()
_triggered: WeakMembers[GuardCondition] = WeakMembers()
_handlers: dict[int, _Handler] = {}
_listeners: list[SignalListener] = []
_passing_on: list[SignalListener] = []
"""A closed listener whose thread stays, since it must still pass signals on."""
_asleep: list[SignalHandlerOptions] = []
"""In a forked child: the options of its parent, until the child uses a context."""
_came: set[int] = set()


def register(shutdown_signal: ShutdownSignal) -> None:
    """Have the handled signals end `shutdown_signal`, which is held weakly."""
    _ended.add(shutdown_signal)


def unregister(shutdown_signal: ShutdownSignal) -> None:
    """Have signals end `shutdown_signal` no longer."""
    _ended.discard(shutdown_signal)


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Handle the signals of `options`, and no others. Does nothing outside the main thread.

    Raises TypeError for anything but a SignalHandlerOptions.
    """
    if not isinstance(options, SignalHandlerOptions):
        raise TypeError(f'options must be SignalHandlerOptions, got {options!r}')
    if threading.current_thread() is not threading.main_thread():
        return
    uninstall_signal_handlers()
    _asleep.clear()
    for number in _WANTED[options]:
        _handlers[number] = handler = _Handler(signal.getsignal(number))
        signal.signal(number, handler)
    if _handlers:
        while _passing_on:
            _passing_on.pop().end_thread()
        _listeners.append(SignalListener(_is_ours, _end_unless))


def uninstall_signal_handlers() -> None:
    """Restore the handlers that were installed before goalwire's. Does nothing outside the main thread."""
    if threading.current_thread() is not threading.main_thread():
        return
    while _listeners:
        listener = _listeners.pop()
        if listener.close():
            listener.end_thread()
        else:
            _passing_on.append(listener)
    _uninstall_handlers()


def _uninstall_handlers() -> None:
    while _handlers:
        number, handler = _handlers.popitem()
        handler.uninstall(number)


def handle_in_child() -> None:
    """In a forked child that uses a context, handle the signals that the parent handled."""
    if _asleep:
        install_signal_handlers(_asleep[0])


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return the option that describes the signals that are handled now."""
    return next(options for options, wanted in _WANTED.items() if set(wanted) == set(_handlers))


def has_come() -> bool:
    """Tell whether a handled signal has come. It normally ends the program."""
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
    """Tell whether IPython or a notebook runs this program. Ctrl-C and Interrupt only end a cell there."""
    get_ipython = getattr(sys.modules.get('IPython'), 'get_ipython', None)
    return get_ipython is not None and get_ipython() is not None


# -- the end of the contexts


def _is_ours(number: int) -> bool:
    """Tell whether our handler is installed for `number`; a program may have replaced it."""
    handler = _handlers.get(number)
    return handler is not None and handler.is_installed(number)


def _end_unless(answered: Callable[[], bool], number: int) -> None:
    """End the contexts on the listener's thread.

    The contexts are listed before the look for an answer. So a context that is made after the main thread has
    run a handler does not end.
    """
    contexts = _ended.alive()
    if _is_ours(number) and not answered():
        _end(contexts, number)


def _end(shutdown_signals: Iterable[ShutdownSignal], number: int) -> None:
    _came.add(number)
    name = signal.Signals(number).name
    for shutdown_signal in shutdown_signals:
        shutdown_signal.end(name)
    for guard in _triggered.alive():
        with suppress(InvalidHandle):
            guard.trigger()


# -- forks

_held = threading.local()
"""The signal mask that the forking thread had before the fork, as `mask`."""


def _hold_signals() -> None:
    """Before a fork, block all signals, so that no signal reaches the child while it shares the parent's
    pipe.
    """
    if is_pipe_open():
        _held.mask = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())


def _let_signals_come() -> None:
    mask = _held.__dict__.pop('mask', None)
    if mask is not None:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _reset_in_child() -> None:
    """In a forked child, have signals act as they would without this library."""
    if _handlers:
        _asleep[:] = [get_current_signal_handlers_options()]
    while _listeners:
        _listeners.pop().close()
    _passing_on.clear()
    _uninstall_handlers()
    _came.clear()
    _let_signals_come()


at_exit(Stage.SIGNALS, uninstall_signal_handlers)
if sys.platform != 'win32':
    os.register_at_fork(
        before=_hold_signals, after_in_parent=_let_signals_come, after_in_child=_reset_in_child
    )
