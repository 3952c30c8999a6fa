"""The threads of a MultiThreadedExecutor."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from goalwire.concurrency.exits import Stage, at_exit
from goalwire.concurrency.threads import begin
from goalwire.execution.time.steady_clock import STEADY
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.ready_queue import CallbackSource

_EXIT_GRACE_NS = 1_000_000_000
"""The time in ns for which the interpreter's exit waits for all threads in user code together."""
_IDLE_GRACE = 1.0
"""The time in s that `close` waits for each thread outside user code to end."""


class WorkerPool:
    """Up to `limit` threads. Each of them runs `serve` until that returns.

    They are daemon threads, so a callback that blocks for ever does not keep the interpreter from ending.
    `wake_all` wakes all sleeping threads, so that they see that they have to end.
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
        'taking',
    )

    def __init__(self, limit: int, serve: Callable[[], None], wake_all: Callable[[], None]) -> None:
        self.limit = limit
        self.closed = False
        self.busy: dict[threading.Thread, CallbackSource] = {}
        """The workers in user code, each with its callback."""
        self.taking: set[threading.Thread] = set()
        """The workers that take work now. A worker leaves this set after it has entered `busy`."""
        self._serve = serve
        self._wake_all = wake_all
        self._lock = threading.Lock()
        self._threads: set[threading.Thread] = set()  # all workers, also those that are about to end
        self.serving: set[threading.Thread] = set()
        """The workers that count against `limit`."""
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
            try:
                begin(thread)
            except RuntimeError:  # Python refuses a further thread
                self._threads.discard(thread)
                self.serving.discard(thread)
                raise

    def raise_limit(self, count: int) -> None:
        """Allow `count` more threads; a negative `count` takes them back."""
        with self._lock:
            self.limit += count

    def retire(self) -> bool:
        """Tell whether there are too many workers, so that the calling worker has to end.

        If so, the worker is not counted from here on. The lock sees to it that of several workers that ask at
        once only the surplus ends.
        """
        with self._lock:
            if len(self) <= self.limit:
                return False
            self.serving.discard(threading.current_thread())
            return True

    def dismiss(self) -> None:
        """Have each thread end as soon as its callback has returned. Idempotent."""
        with self._lock:
            self.closed = True
        self._wake_all()

    def close(self) -> None:
        """End all threads, and wait for those outside user code. Idempotent."""
        self.dismiss()
        for thread in list(self._threads):
            if not thread.is_alive():
                continue  # Ctrl-C may have kept it from starting, and join() would raise
            if thread is not threading.current_thread() and thread not in self.busy:
                thread.join(_IDLE_GRACE)

    def reset_in_child(self) -> None:
        """In a forked child, forget the threads: they are the parent's."""
        self._lock = threading.Lock()
        for threads in (self.busy, self.taking, self._threads, self.serving):
            threads.clear()

    def await_end(self, deadline: int | None) -> bool:
        """Wait until all threads but the calling one have ended; False at `deadline` (steady ns)."""
        for thread in list(self._threads):
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(None if deadline is None else max(deadline - STEADY.now(), 0) / 1e9)
                if thread.is_alive():
                    return False
        return True

    def _run(self) -> None:
        try:
            self._serve()
        finally:
            with self._lock:
                self.serving.discard(threading.current_thread())
            self.taking.discard(threading.current_thread())
            self._threads.discard(threading.current_thread())


_pools: WeakMembers[WorkerPool] = WeakMembers()


def _close_all() -> None:
    """End all threads at the interpreter's exit, before the libraries that they use are torn down."""
    pools = _pools.alive()
    for pool in pools:
        pool.dismiss()
    deadline = STEADY.now() + _EXIT_GRACE_NS
    for pool in pools:
        pool.await_end(deadline)


at_exit(Stage.THREADS, _close_all)
