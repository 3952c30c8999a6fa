"""Signal handlers that run in an asyncio loop, for programs that use launch.utilities."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable
from typing import Any, Self

Handler = Callable[[int], None]


class AsyncSafeSignalManager:
    """Calls signal handlers in an asyncio loop inside a `with` block, then restores the previous handlers.

    The block may be entered several times. Only the main thread can enter it.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._handlers: dict[int, Handler] = {}
        self._before: dict[int, Any] = {}
        self._entered = False

    def handle(self, signum: signal.Signals | int, handler: Handler | None) -> Handler | None:
        """Set the handler of a signal, or remove it with None; return the previous handler."""
        number = int(signum)
        before = self._handlers.pop(number, None)
        if handler is not None:
            self._handlers[number] = handler
        if self._entered:
            self._remove(number)
            if handler is not None:
                self._install(number)
        return before

    def __enter__(self) -> Self:
        for number in self._handlers:
            self._install(number)
        self._entered = True
        return self

    def __exit__(self, *_: object) -> None:
        self._entered = False
        for number in list(self._before):
            self._remove(number)

    def _install(self, number: int) -> None:
        self._before[number] = signal.getsignal(number)
        self._loop.add_signal_handler(number, self._handlers[number], signal.Signals(number))

    def _remove(self, number: int) -> None:
        if number in self._before:
            self._loop.remove_signal_handler(number)
            signal.signal(number, self._before.pop(number))
