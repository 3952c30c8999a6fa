"""The interpreter's exit: closes open objects in order, each by its own step, even if Ctrl-C comes.

A program need not shut anything down. Python calls the functions of `atexit` once its non-daemon threads have
ended; its daemon threads still run, and may spin. So contexts end first: spins return, and callbacks that
still try to send get an error. Then sessions close, and threads and coroutines end.

Functions that a program registers with `atexit` after it has imported rclpy run before all this: they find
everything open.
"""

from __future__ import annotations

import atexit
import signal
import sys
from collections.abc import Callable, Iterable
from enum import IntEnum
from threading import current_thread, main_thread
from types import FrameType


class Stage(IntEnum):
    """The order in which things are closed."""

    CONTEXTS = 0
    SESSIONS = 1
    LIBRARIES = 2
    THREADS = 3
    SIGNALS = 4


_steps: dict[Stage, list[Callable[[], object]]] = {stage: [] for stage in Stage}
_begun: list[None] = []


def at_exit(stage: Stage, step: Callable[[], object]) -> None:
    """Have `step` called at the interpreter's exit."""
    _steps[stage].append(step)


def has_begun() -> bool:
    """True if the interpreter's exit has begun to close things."""
    return bool(_begun)


def perform(steps: Iterable[Callable[[], object]]) -> None:
    """Perform all steps, even if some of them raise; raise the first of these errors at the end."""
    failure: BaseException | None = None
    for step in steps:
        try:
            step()
        except BaseException as error:
            failure = failure or error
    if failure is not None:
        raise failure


@atexit.register
def _close_all() -> None:
    _ignore_ctrl_c_once()
    _forget_caught_ctrl_c()
    _begun.append(None)
    perform([step for stage in Stage for step in _steps[stage]])


def _ignore_ctrl_c_once() -> None:
    """Ignore the first Ctrl-C, as the program ends anyway. A second Ctrl-C kills it. Only Python's own
    handler and goalwire's are replaced. A handler of the program's stays.
    """
    if current_thread() is main_thread() and signal.getsignal(signal.SIGINT) == signal.default_int_handler:
        signal.signal(signal.SIGINT, _kill_next_time)


def _forget_caught_ctrl_c() -> None:
    """Have a program that has caught Ctrl-C end with its own exit status.

    CPython sets a flag if a KeyboardInterrupt leaves code that `exec` or `eval` has compiled from text. With
    that flag the process ends as if by Ctrl-C, even if the program has caught the exception since
    (`run_eval_code_obj` of CPython's pythonrun.c). Named tuples and our own generated code are compiled from
    text, some of it within the first spin.
    """
    # Python sets `last_type` only for an exception that nobody caught
    if getattr(sys, 'last_type', None) is not KeyboardInterrupt:
        exec('')  # noqa: S102 - clears the flag


def _kill_next_time(number: int, _frame: FrameType | None) -> None:
    signal.signal(number, signal.SIG_DFL)
