"""Handles Ctrl-C before a command has an event loop, and during discovery.

Python turns SIGINT into an exception wherever the main thread is. During an import, the main thread may be in
a finaliser or a weak reference's callback, where exceptions are printed and lost: the command would go on.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from goalwire.apps.cli.framework.outcome import Outcome


def end_at_once() -> None:
    """Let Ctrl-C end the process with the code of SIGINT. If nohup ignores SIGINT, it stays ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


@contextmanager
def raise_interrupts() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt in the block, so that the block closes what it has opened."""
    if signal.getsignal(signal.SIGINT) is not _end:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, _end)


def _end(_number: int, _frame: FrameType | None) -> None:
    os._exit(Outcome.INTERRUPTED)
