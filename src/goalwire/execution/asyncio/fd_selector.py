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

    A descriptor is reported once, then not watched until its loop arms it again. Otherwise a descriptor that
    a busy loop has not read yet would end every sleep at once.
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
        """Make a selector. `on_armed` wakes a sleeping thread, which then waits in this selector."""
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
        """Have `report(fd, ready_events)` called once when one of `events` is ready."""
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
                return  # it was reported already, which has disarmed it
            self.watched -= 1

    def poll(self) -> None:
        """Report the descriptors that are ready now. Does nothing while another thread does so."""
        self.wait(0, bool)

    def wait(self, timeout: float | None, woken: Callable[[], bool]) -> bool:
        """Report the ready descriptors, after waiting up to `timeout` s; False while another thread does so.

        `woken` is called after this thread has taken the turn. Before that, another thread in `select` might
        consume an `interrupt` that was meant for this thread; `woken` then tells that it came.
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
                # Another thread wanted to wait here. Wake it to take over, since this thread may be long
                # away.
                self.wanted = False
                self._on_armed()
        for key, events in ready:
            if key.data is not None:
                self.disarm(key.fd)
                key.data(key.fd, events)
        return True

    def interrupt(self) -> None:
        """End the `wait` of another thread. Callable from any thread."""
        if self._interrupt is not None:
            # An OSError means that the socket is full (then the wait ends anyway) or closed (then no thread
            # waits).
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

        The child shares the kernel's part of the selector with its parent. So it changes nothing there, and
        only closes its own descriptor.
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
