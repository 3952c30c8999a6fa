"""A thread that hears of signals at once, whatever the main thread is doing.

Python runs handlers in the main thread, between two steps of Python code. A signal that comes after the last
step before a call of the system's, `time.sleep(20)` in a callback, is seen when that call is over; so is one
that the system gives to another thread. Another signal ends such a call: SIGURG, which means nothing to most
programs, is sent to the main thread while it has not run the handler.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from contextlib import suppress
from threading import get_ident
from time import monotonic_ns
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from goalwire.transport.contract import WirePoller

_CLOSE = 0
"""No signal has this number."""
_NUDGES_MS = (20, 200, 2000)
"""After so long each, the main thread is looked after that has not run a signal's handler."""
_EARLIER_NS = 10_000_000
"""How much before this thread has read of a signal its handler may have run."""

LISTENING: list[SignalListener] = []
"""The listener of this process, if there is one."""


class SignalListener:
    """Calls `on_signal(number)` on its own thread for each signal that has a Python handler.

    It returns whether the main thread must run its handler soon, which says so by `noticed`. Python's C
    handler writes the numbers into a pipe (`signal.set_wakeup_fd`). Main thread only.
    """

    def __init__(self, on_signal: Callable[[int], bool]) -> None:
        self.main_thread = get_ident()
        self.wire_poller: WirePoller | None = None
        """What the main thread waits in, where no signal reaches it."""
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
        self._noticed_ns = monotonic_ns()

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
                        nudges, heard_ns = iter(_NUDGES_MS), monotonic_ns()
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
