"""Signals wake the loop of the main thread while a node is open on that loop.

Python only notes a signal when it comes; the handler runs between two bytecode instructions. If the signal
comes after the last instruction before the loop's wait, nothing ends that wait, and the handler runs when the
loop wakes for another reason. `asyncio.run` handles Ctrl-C by such a handler: of 1,500 programs three missed
it. A wake-up descriptor ends the wait. uvloop always installs one, asyncio only for the handlers
of `loop.add_signal_handler`.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.execution.signals.signal_pipe import signal_pipe

if TYPE_CHECKING:
    import asyncio

_PIPE_BYTES = 4096
"""The most numbers of signals that one turn of the loop takes from the pipe."""


def wake_for_signals(loop: asyncio.AbstractEventLoop) -> int:
    """Let every signal wake `loop`, and return the descriptor that the loop watches for it.

    Return -1, and change nothing, on other threads than the main thread, if another wake-up descriptor is
    installed, and if the loop cannot watch descriptors. To be called on the loop's thread.
    """
    with suppress(OSError, NotImplementedError):  # too many open files, or a loop that watches none
        pipe = signal_pipe('loop')
        if pipe.take_if_free():
            try:
                loop.add_reader(pipe.reader, os.read, pipe.reader, _PIPE_BYTES)
            except BaseException:
                pipe.give_back()
                raise
            return pipe.reader
    return -1


def stop_waking_for_signals(loop: asyncio.AbstractEventLoop) -> None:
    """End what `wake_for_signals` has begun. To be called on the loop's thread or, once the loop is closed,
    on any thread.
    """
    pipe = signal_pipe('loop')
    loop.remove_reader(pipe.reader)
    with suppress(ValueError):  # not the main thread: the pipe stays installed, and nobody reads it
        pipe.give_back()
