"""Watches the file descriptors of an executor's asyncio loops, in one selector."""

from __future__ import annotations

from _thread import allocate_lock
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.concurrency.sigpipe import NO_SIGPIPE

if TYPE_CHECKING:
    import selectors
    import socket
    from collections.abc import Callable


class FdSelector:
    """One selector for all asyncio loops of an executor; made when the first descriptor is watched.

    A descriptor is reported once, then left alone until its loop arms it again, so that one which a busy
    loop has not served yet keeps nobody awake.
    """

    __slots__ = (
        '_closed',
        '_interrupt',
        '_listener',
        '_lock',
        '_on_armed',
        '_selecting',
        '_selector',
        '_turn',
        'wanted',
        'watched',
    )

    def __init__(self, on_armed: Callable[[], None]) -> None:
        """`on_armed` gets a sleeper to look again, which then watches the descriptors."""
        self.watched = 0
        self.wanted = False
        self._on_armed = on_armed
        self._selector: selectors.BaseSelector | None = None
        self._interrupt: socket.socket | None = None
        self._listener: socket.socket | None = None
        self._selecting = False
        self._turn = allocate_lock()
        self._lock = allocate_lock()
        self._closed = False

    def arm(self, fd: int, events: int, report: Callable[[int, int], None]) -> None:
        """Call `report(fd, ready_events)` once when one of `events` is ready."""
        with self._lock:
            if self._closed:
                return
            selector = self._selector or self._open()
            selector.register(fd, events, report)
            self.watched += 1
        if self._selecting:
            self.interrupt()
        else:
            self._on_armed()

    def disarm(self, fd: int) -> None:
        """Stop watching `fd`, if it is watched."""
        with self._lock:
            if self._selector is None:
                return
            try:
                self._selector.unregister(fd)
            except KeyError:
                return  # it has been reported since
            self.watched -= 1

    def poll(self) -> None:
        """Report the descriptors that are ready now; nothing if another thread does so already."""
        self.wait(0, bool)

    def wait(self, timeout: float | None, woken: Callable[[], bool]) -> bool:
        """Report what is ready, after waiting up to `timeout` s; False if another thread is at it.

        `woken` is asked once this thread has its turn: from then on no other thread's look can take up an
        `interrupt` that is meant for this one.
        """
        if not self._turn.acquire(blocking=False):
            return False
        try:
            self._selecting = timeout != 0
            selector = self._selector
            ready = [] if selector is None or woken() else selector.select(timeout)
            if any(key.data is None for key, _ in ready):
                self._drain()
        finally:
            self._selecting = False
            self._turn.release()
            if self.wanted:
                # A sleeper found the selector taken: let it look again, as this thread may be long away.
                self.wanted = False
                self._on_armed()
        for key, events in ready:
            if key.data is not None:
                self.disarm(key.fd)
                key.data(key.fd, events)
        return True

    def interrupt(self) -> None:
        """End a `poll` that waits. Any thread."""
        if self._interrupt is not None:
            # Full: it is being interrupted already. Closed: no thread waits.
            with suppress(OSError):
                self._interrupt.send(b'\0', NO_SIGPIPE)

    def close(self) -> None:
        """Close the selector, once the thread that waits in it has left, and watch nothing from now on."""
        with self._lock:
            self._closed = True
            selector, self._selector = self._selector, None
            self.watched = 0
        if selector is None:
            return
        self.interrupt()
        with self._turn:
            selector.close()
            for end in (self._interrupt, self._listener):
                if end is not None:
                    end.close()

    def reset_in_child(self) -> None:
        """In a forked child, open another selector, which watches nothing yet.

        The kernel's part of the selector is the parent's too: it is left as it is, and closed here alone.
        """
        self._turn, self._lock = allocate_lock(), allocate_lock()
        self._selecting = self.wanted = False
        self.watched = 0
        selector, self._selector = self._selector, None
        if selector is not None:
            selector.close()
        for end in (self._interrupt, self._listener):
            if end is not None:
                end.close()

    def _open(self) -> selectors.BaseSelector:
        import selectors
        import socket

        self._listener, self._interrupt = socket.socketpair()
        self._listener.setblocking(False)
        self._interrupt.setblocking(False)
        selector = self._selector = selectors.DefaultSelector()
        selector.register(self._listener, selectors.EVENT_READ, None)
        return selector

    def _drain(self) -> None:
        if self._listener is not None:
            self._listener.recv(4096)
