"""SIGINT and SIGTERM end the contexts (rclpy.signals).

The handlers take no lock: they may interrupt the main thread anywhere. They end the registered lifelines,
which wakes every thread that waits under them, and then do what was installed before them: for SIGINT that
is Python's own handler, which raises KeyboardInterrupt.
"""

from __future__ import annotations

import signal
import threading
from enum import Enum
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from goalwire.execution.guard_condition import GuardCondition

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.execution.lifeline import ContextLike, Lifeline


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
_lifelines: WeakSet[Lifeline] = WeakSet()
_guards: WeakSet[GuardCondition] = WeakSet()
_previous: dict[signal.Signals, Any] = {}


def register(lifeline: Lifeline) -> None:
    """Let the handled signals end `lifeline`, which is held weakly."""
    _lifelines.add(lifeline)


def unregister(lifeline: Lifeline) -> None:
    """Let signals leave `lifeline` alone."""
    _lifelines.discard(lifeline)


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Handle the signals of `options`, and no others. Does nothing outside the main thread."""
    if threading.current_thread() is not threading.main_thread():
        return
    uninstall_signal_handlers()
    for number in _WANTED[options]:
        _previous[number] = signal.signal(number, _handle)


def uninstall_signal_handlers() -> None:
    """Put back what was installed before. Does nothing outside the main thread."""
    if threading.current_thread() is not threading.main_thread():
        return
    while _previous:
        number, previous = _previous.popitem()
        if signal.getsignal(number) is _handle:
            signal.signal(number, signal.SIG_DFL if previous is None else previous)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Which signals are handled now."""
    handled = set(_previous)
    return next(options for options, wanted in _WANTED.items() if set(wanted) == handled)


class SignalHandlerGuardCondition(GuardCondition):
    """A guard condition that every handled signal triggers."""

    __slots__ = ()

    def __init__(self, context: ContextLike | None = None) -> None:
        super().__init__(None, None, context)
        _guards.add(self)

    def destroy(self) -> None:
        _guards.discard(self)
        super().destroy()


def _handle(number: int, frame: FrameType | None) -> None:
    name = signal.Signals(number).name
    for lifeline in tuple(_lifelines):
        lifeline.end(name)
    for guard in tuple(_guards):
        guard.trigger()
    previous = _previous.get(signal.Signals(number))
    if callable(previous):
        previous(number, frame)
