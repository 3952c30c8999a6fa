"""Lets an idle thread wait on the wire instead of a lock, so that a message wakes the thread that wants it.

A session that has sockets of its own offers a `WirePoller`. Idle threads wait in it, each as a `Sleeper`;
`leader_followers` implements it.
"""

from __future__ import annotations

from _thread import allocate_lock
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Protocol


class Sleeper(Protocol):
    """An idle thread."""

    interrupt: Callable[[], None] | None
    """Ends the sleep of a thread that sleeps on the wire, not on its lock; `wake` calls it."""
    take_wake: Callable[[], bool]
    """Takes a wake-up that came earlier, without sleeping; False if there is none.

    hot path: it is a function of C, which saves two calls at each sleep."""

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        """Sleep on a lock until `wake` (True) or for `timeout_ns` (False)."""

    def wake(self) -> None:
        """End this thread's sleep, on the wire or on its lock. Any thread or signal handler may call it."""


class SleepingThread:
    """A thread that blocks in a call until an awaited event."""

    __slots__ = ('_gate', 'interrupt', 'take_wake')

    def __init__(self) -> None:
        self.interrupt: Callable[[], None] | None = None
        self._gate = allocate_lock()
        self._gate.acquire()
        self.take_wake: Callable[[], bool] = partial(self._gate.acquire, False)

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
    """Lets one idle thread of a session wait on the wire itself, so that a message wakes it at once.

    That thread then delivers what has come. The others sleep on their locks (the pattern Leader/Followers).
    """

    external_sleepers: set[object]
    """Sleepers that cannot wait on the wire themselves, and so need the session's own thread to wait here.
    While there are any, no other thread begins to wait on the wire."""

    @abstractmethod
    def wait(self, sleeper: Sleeper, timeout_ns: int | None) -> bool:
        """Sleep until `sleeper` is woken (True) or for `timeout_ns` (False), on the wire if no thread has it.

        True may be a false alarm, so the caller must check its condition again.
        """

    @abstractmethod
    def ensure_polled(self) -> None:
        """Have some thread wait on the wire, since sleepers depend on it. Any thread may call this."""

    @abstractmethod
    def interrupt(self) -> None:
        """Interrupt the thread that waits on the wire, so that it runs signal handlers. Any thread may call
        this.
        """

    def attach_loop(self) -> int | None:
        """Let an asyncio loop, on the calling thread, read the wire until `detach_loop`.

        Returns a descriptor that is readable while `serve_ready` has events to deliver. The caller closes it.
        None if the wire has no such descriptor.
        """
        return None

    def detach_loop(self, thread: int) -> None:  # noqa: B027 - nothing to undo where none can be attached
        """Undo one `attach_loop` of a thread, given by `get_ident()`. Any thread may call this, after the
        loop's end.
        """

    def serve_ready(self) -> float:
        """Deliver the present events; return the time, on the monotonic clock, of the next call at the
        latest.
        """
        return float('inf')
