"""A thread that hears of signals at once, whatever the main thread is doing."""

from __future__ import annotations

import os
import signal
import sys
import threading
from contextlib import suppress
from threading import get_ident
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.transport.contract import Vigil

_CLOSE = 0
"""No signal has this number."""

LISTENING: list[SignalListener] = []
"""The listener of this process, if there is one."""


class SignalListener:
    """Calls `on_signal(number)` on its own thread for each signal that has a Python handler.

    Python's C handler writes the numbers into a pipe (`signal.set_wakeup_fd`). Main thread only.
    """

    def __init__(self, on_signal: Callable[[int], None]) -> None:
        self.main_thread = get_ident()
        self.vigil: Vigil | None = None
        """What the main thread waits in, where no signal reaches it."""
        self._on_signal = on_signal
        self._process = os.getpid()
        self._reader, self._writer = os.pipe()
        if sys.platform != 'win32':
            os.set_blocking(self._writer, False)
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

    def close(self) -> None:
        """Put back what was there before and end the thread."""
        with suppress(ValueError):
            LISTENING.remove(self)
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
        with suppress(OSError):
            while True:
                for number in os.read(self._reader, 64):
                    if number == _CLOSE:
                        return
                    self._on_signal(number)
                    vigil = self.vigil
                    if vigil is not None:
                        vigil.interrupt()
