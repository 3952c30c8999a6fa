"""SIGINT and SIGTERM end the contexts (rclpy.signals).

The handlers take no lock: they may interrupt the main thread anywhere. They end the registered shutdown
signals, which wakes every thread that waits under them, and then do what was installed before them: for
SIGINT that is Python's own handler, which raises KeyboardInterrupt.

A listener thread ends the shutdown signals too, and first. Python runs handlers in the main thread, and a
signal that comes in the microseconds before that thread falls asleep on a lock is noticed at its next waking
only.
"""

from __future__ import annotations

import atexit
import os
import signal
import threading
from contextlib import suppress
from enum import Enum
from typing import TYPE_CHECKING, Any
from weakref import ref

from goalwire.errors import InvalidHandle
from goalwire.execution.guard_condition import GuardCondition
from goalwire.execution.signal_listener import SignalListener

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.execution.shutdown_signal import ContextLike, ShutdownSignal


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
_lifelines: dict[int, ref[ShutdownSignal]] = {}
_guards: dict[int, ref[GuardCondition]] = {}
"""By id. Copied in one step where they are gone through, since another thread may change them."""
_previous: dict[signal.Signals, Any] = {}
_listeners: list[SignalListener] = []
_came: set[int] = set()


def register(shutdown_signal: ShutdownSignal) -> None:
    """Let the handled signals end `shutdown_signal`, which is held weakly."""
    key = id(shutdown_signal)
    _lifelines[key] = ref(shutdown_signal, lambda _: _lifelines.pop(key, None))


def unregister(shutdown_signal: ShutdownSignal) -> None:
    """Let signals leave `shutdown_signal` alone."""
    _lifelines.pop(id(shutdown_signal), None)


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
        _listeners.append(SignalListener(_end_contexts))


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
        key = id(self)
        _guards[key] = ref(self, lambda _: _guards.pop(key, None))

    def destroy(self) -> None:
        _guards.pop(id(self), None)
        super().destroy()


def _end_contexts(number: int) -> bool:
    """What every handled signal does; on the listener's thread and in the main one. False for others."""
    if number not in _previous:
        return False
    _came.add(number)
    name = signal.Signals(number).name
    for shutdown_signal in [reference() for reference in tuple(_lifelines.values())]:
        if shutdown_signal is not None:
            shutdown_signal.end(name)
    for guard in [reference() for reference in tuple(_guards.values())]:
        if guard is not None:
            with suppress(InvalidHandle):
                guard.trigger()
    return True


def _handle(number: int, frame: FrameType | None) -> None:
    for listener in _listeners:
        listener.noticed()
    _end_contexts(number)
    previous = _previous.get(signal.Signals(number))
    if callable(previous):
        previous(number, frame)


def _forget_in_child() -> None:
    """After fork: signals to the child must not be written into the pipe that it shares with its parent."""
    while _listeners:
        _listeners.pop().close()


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_forget_in_child)
atexit.register(uninstall_signal_handlers)
