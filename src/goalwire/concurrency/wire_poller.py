"""Waiting on a wire instead of on a lock, so that an incoming message wakes the thread that wants it.

A session that has sockets of its own offers a `WirePoller`. Threads with nothing to do wait in it, each as a
`Sleeper`; `leader_followers` is what fulfils it.
"""

from __future__ import annotations

from _thread import allocate_lock
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol


class Sleeper(Protocol):
    """A thread that has nothing to do."""

    interrupt: Callable[[], None] | None
    """Ends its sleep while it sleeps elsewhere than on its lock; `wake` calls it."""

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        """Sleep on a lock until `wake` (True) or for `timeout_ns` (False); 0 takes up a wake-up that came."""

    def wake(self) -> None:
        """End its sleep, wherever it sleeps. Any thread, signal handlers too."""


class SleepingThread:
    """A thread that blocks in a call until an awaited event."""

    __slots__ = ('_gate', 'interrupt')

    def __init__(self) -> None:
        self.interrupt: Callable[[], None] | None = None
        self._gate = allocate_lock()
        self._gate.acquire()

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        """Sleep on the lock."""
        if timeout_ns is None:
            return self._gate.acquire()
        if timeout_ns <= 0:
            return self._gate.acquire(blocking=False)
        return self._gate.acquire(timeout=timeout_ns / 1e9)

    def wake(self) -> None:
        """Wake the sleeping thread."""
        try:
            self._gate.release()
        except RuntimeError:
            return
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()


class WirePoller(ABC):
    """Waiting on the wire itself, which one idle thread of the session does: so what comes wakes it at once.

    That thread then delivers what has come. The others sleep on their locks (the pattern Leader/Followers).
    """

    external_sleepers: set[object]
    """Sleepers that do not wait on the wire themselves, and so need the session's own thread to wait here.
    While there are any, no other thread begins to."""

    @abstractmethod
    def wait(self, sleeper: Sleeper, timeout_ns: int | None) -> bool:
        """Sleep until `sleeper` is woken (True) or for `timeout_ns` (False), on the wire where that is free.

        True may also mean nothing, so look again.
        """

    @abstractmethod
    def ensure_polled(self) -> None:
        """Have some thread wait on the wire: others depend on that. Any thread."""

    @abstractmethod
    def interrupt(self) -> None:
        """Let the thread that waits on the wire run a signal handler. Any thread."""

    def attach_loop(self) -> int | None:
        """Let an asyncio loop, on the calling thread, read the wire until `detach_loop`.

        Returns a descriptor of its own that is readable while there is something for `serve_ready`, for the
        caller to close. None if the wire has no such thing.
        """
        return None

    def detach_loop(self, thread: int) -> None:  # noqa: B027 - nothing to undo where none can be attached
        """Undo one `attach_loop` of that thread (`get_ident()`). Any thread, once the loop is closed."""

    def serve_ready(self) -> float:
        """Deliver the present events; return when to call this again at the latest, on the monotonic
        clock.
        """
        return float('inf')
