"""Ctrl-C before a command has a loop that takes it, and while it looks at the graph.

Python turns SIGINT into an exception wherever the main thread is. While modules are imported that may be in a
finaliser or a callback of a weak reference, where exceptions are printed and lost: the command would go on.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from goalwire.apps.cli.framework.outcome import Outcome


def end_at_once() -> None:
    """Have Ctrl-C end the process with its code; if SIGINT is ignored, as under nohup, it stays so."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


@contextmanager
def raised() -> Iterator[None]:
    """Have Ctrl-C raise KeyboardInterrupt in the block, so that open things in it are closed."""
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
