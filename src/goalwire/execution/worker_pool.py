"""The threads of a MultiThreadedExecutor: made on demand, ended together."""

from __future__ import annotations

import atexit
import threading
from typing import TYPE_CHECKING
from weakref import WeakSet

from goalwire.execution.monotonic import STEADY

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.callback_source import CallbackSource

_EXIT_GRACE = 1.0
"""s that the interpreter's exit waits for each thread that is in user code."""


class WorkerPool:
    """Up to `limit` threads, each of which runs `serve` until that returns.

    They are daemons: a callback that blocks for ever does not keep the interpreter from ending. `rouse` wakes
    all that sleep, so that they see they are dismissed.
    """

    __slots__ = (
        '__weakref__',
        '_lock',
        '_serve',
        '_threads',
        '_wake_all',
        'busy',
        'closed',
        'limit',
        'serving',
    )

    def __init__(self, limit: int, serve: Callable[[], None], wake_all: Callable[[], None]) -> None:
        self.limit = limit
        self.closed = False
        self.busy: dict[threading.Thread, CallbackSource] = {}
        """Those in user code, and at what."""
        self._serve = serve
        self._wake_all = wake_all
        self._lock = threading.Lock()
        self._threads: set[threading.Thread] = set()  # all that live
        self.serving: set[threading.Thread] = set()
        """Those that were not let go."""
        _pools.add(self)

    def __len__(self) -> int:
        return len(self.serving)

    def start_worker(self) -> None:
        """Start one more thread, unless there are enough."""
        if len(self) >= self.limit:
            return
        with self._lock:
            if self.closed or len(self) >= self.limit:
                return
            thread = threading.Thread(target=self._run, name='goalwire-callbacks', daemon=True)
            self._threads.add(thread)
            self.serving.add(thread)
            thread.start()

    def retire(self) -> bool:
        """Whether the calling thread is one too many and has to leave: from here on it does not count.

        Of several that ask at once no more are let go than there are too many.
        """
        with self._lock:
            if len(self) <= self.limit:
                return False
            self.serving.discard(threading.current_thread())
            return True

    def close(self) -> None:
        """Send all threads home; wait for those that are in no user code. Idempotent."""
        with self._lock:
            self.closed = True
        self._wake_all()
        self._join(idle_only=True)

    def await_end(self, deadline: int | None) -> bool:
        """Wait until all threads but the calling one have ended; False at `deadline` (steady ns)."""
        for thread in tuple(self._threads):
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(None if deadline is None else max(deadline - STEADY.now(), 0) / 1e9)
                if thread.is_alive():
                    return False
        return True

    def _join(self, *, idle_only: bool) -> None:
        for thread in tuple(self._threads):
            if not thread.is_alive():
                continue  # Ctrl-C came while it was being started
            if thread is not threading.current_thread() and not (idle_only and thread in self.busy):
                thread.join(_EXIT_GRACE)

    def _run(self) -> None:
        try:
            self._serve()
        finally:
            with self._lock:
                self.serving.discard(threading.current_thread())
            self._threads.discard(threading.current_thread())


_pools: WeakSet[WorkerPool] = WeakSet()


@atexit.register
def _close_all() -> None:
    """At the interpreter's exit no thread may be left inside a library that is being torn down."""
    for pool in tuple(_pools):
        pool.close()
        pool._join(idle_only=False)  # noqa: SLF001
