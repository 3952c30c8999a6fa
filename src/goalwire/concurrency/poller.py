"""Waiting until a socket is ready, a timer is due, or another thread calls.

On Linux by epoll and eventfd; elsewhere by `selectors` and a pair of sockets, with the same methods. epoll's
timeout is in milliseconds, rounded up. So `select`, whose timeout is in microseconds, waits for the last
fraction, and only watches epoll's own descriptor.
"""

from __future__ import annotations

import heapq
import os
import select
import selectors
import socket
from collections import deque
from collections.abc import Callable, Sized
from contextlib import suppress
from itertools import count
from threading import RLock
from time import monotonic
from typing import TypeAlias

from goalwire.concurrency.sigpipe import NO_SIGPIPE
from goalwire.fault_reports import report_failure

IN, OUT = 1, 4
"""The values of EPOLLIN and EPOLLOUT."""
IS_PORTABLE = not (hasattr(select, 'epoll') and hasattr(os, 'eventfd'))
"""True if this system lacks epoll or eventfd, which only Linux has."""

Handler: TypeAlias = Callable[[int], None]
"""A handler of a descriptor's events: bits of IN and OUT, or other bits if the connection has ended."""

_SOME = 64
"""How many cancelled timers are always kept until they are due."""
_FORMER_DESCRIPTORS = 1024
"""How many descriptors `select` can watch at most."""


class Timer:
    """Calls its function once, unless it is cancelled before that."""

    __slots__ = ('_when_cancelled', 'function', 'when')

    def __init__(self, when: float, function: Callable[[], None], when_cancelled: Callable[[], None]) -> None:
        self.when = when
        self.function: Callable[[], None] | None = function
        self._when_cancelled = when_cancelled

    def cancel(self) -> None:
        """Cancel the call."""
        if self.function is not None:
            self.function = None
            self._when_cancelled()


class _Portable:
    """The methods of epoll, done by `selectors`: for systems without epoll, and for testing this code on
    Linux.
    """

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._lock = RLock()

    def register(self, fd: int, events: int) -> None:
        with self._lock:
            self._selector.register(fd, self._translate(events))

    def modify(self, fd: int, events: int) -> None:
        with self._lock:
            self._selector.modify(fd, self._translate(events))

    def unregister(self, fd: int) -> None:
        with self._lock:
            self._selector.unregister(fd)

    @staticmethod
    def _translate(events: int) -> int:
        reads, writes = selectors.EVENT_READ, selectors.EVENT_WRITE
        return (reads if events & IN else 0) | (writes if events & OUT else 0)

    def poll(self, timeout: float | None = None) -> list[tuple[int, int]]:
        return [
            (
                key.fd,
                (IN if events & selectors.EVENT_READ else 0) | (OUT if events & selectors.EVENT_WRITE else 0),
            )
            for key, events in self._selector.select(timeout)
        ]

    def close(self) -> None:
        self._selector.close()


class _EventFd:
    """A bell: its descriptor becomes readable when a thread rings it."""

    def __init__(self) -> None:
        self._fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def fileno(self) -> int:
        return self._fd

    def ring(self) -> None:
        os.eventfd_write(self._fd, 1)

    def quiet(self) -> None:
        os.eventfd_read(self._fd)

    def close(self) -> None:
        """Close the descriptor once: its number may be another file's afterwards."""
        fd, self._fd = self._fd, -1
        if fd >= 0:
            os.close(fd)


class _SocketPair:
    """A bell for systems without eventfd: one byte in a pair of sockets."""

    def __init__(self) -> None:
        self._inner, self._outer = socket.socketpair()
        self._inner.setblocking(False)
        self._outer.setblocking(False)

    def fileno(self) -> int:
        return self._inner.fileno()

    def ring(self) -> None:
        with suppress(BlockingIOError):
            self._outer.send(b'\0', NO_SIGPIPE)

    def quiet(self) -> None:
        self._inner.recv(4096)

    def close(self) -> None:
        self._inner.close()
        self._outer.close()


class Poller:
    """The descriptors and timers of one session. One thread at a time waits; any thread may change them."""

    def __init__(
        self,
        name: str,
        *,
        portable: bool = IS_PORTABLE,
        before_sleep: tuple[Sized, Callable[[], object]] = ((), bool),
        awaited: Sized = (),
    ) -> None:
        """`name` stands in log lines about errors of handlers; `portable` avoids all that only Linux has.

        `before_sleep` is a collection and a function: the function is called before a sleep if the collection
        is not empty. `awaited` is the value of `WireSet.awaited`.
        """
        self.closed = False
        self._name = name
        self.awaited = awaited
        self._unsent, self._send_unsent = before_sleep
        self._portable = portable
        self._poller: select.epoll | _Portable = _Portable() if portable else select.epoll()
        self._bell: _EventFd | _SocketPair = _SocketPair() if portable else _EventFd()
        self._bell_fd = self._bell.fileno()
        self._handlers: dict[int, Handler] = {self._bell_fd: self._quiet}
        self._events: list[tuple[int, int]] = []
        # Guards the timers. Reentrant for signal handlers: each step leaves the timers consistent.
        self._lock = RLock()
        self._timers: list[tuple[float, int, Timer]] = []
        self._cancelled = 0
        self._next_timer = count().__next__
        self._next_due = float('inf')
        self._calls: deque[Callable[[], None]] = deque()
        self._poller.register(self._bell_fd, IN)
        fd = self.descriptor()
        self._precise = fd if fd is not None and fd < _FORMER_DESCRIPTORS else None
        """epoll's own descriptor if `select` can wait for it, else None."""

    # ---- what is waited for

    def register(self, fd: int, events: int, handler: Handler) -> None:
        """Call `handler` while the descriptor is ready for one of `events`."""
        self._handlers[fd] = handler
        self._poller.register(fd, events)
        self._look_again()

    def modify(self, fd: int, events: int) -> None:
        """Wait for other events of a descriptor. An unregistered descriptor is ignored."""
        with suppress(OSError, KeyError, ValueError):
            self._poller.modify(fd, events)
            self._look_again()

    def unregister(self, fd: int) -> None:
        """Stop waiting for a descriptor. An unregistered descriptor is ignored."""
        if self._handlers.pop(fd, None) is not None:
            with suppress(OSError, KeyError, ValueError):
                self._poller.unregister(fd)

    def _look_again(self) -> None:
        if self._portable:  # a selector may still wait for the earlier events
            self.interrupt()

    def call_later(self, delay_s: float, function: Callable[[], None]) -> Timer:
        """Call `function` after `delay_s`, on the thread that then waits in this poller."""
        timer = Timer(monotonic() + delay_s, function, self._note_cancelled)
        with self._lock:
            heapq.heappush(self._timers, (timer.when, self._next_timer(), timer))
            is_next = timer.when < self._next_due
            if is_next:
                self._next_due = timer.when
        if is_next:
            self.interrupt()
        return timer

    def _note_cancelled(self) -> None:
        """Count a cancelled timer. If most timers are cancelled, remove the cancelled ones now."""
        with self._lock:
            self._cancelled += 1
            if self._cancelled > _SOME and 2 * self._cancelled > len(self._timers):
                timers, self._timers, self._cancelled = self._timers, [], 0
                for each in timers:
                    if each[2].function is not None:
                        heapq.heappush(self._timers, each)

    def call(self, function: Callable[[], None]) -> None:
        """Call `function` soon, on the thread that waits in this poller."""
        self._calls.append(function)
        self.interrupt()

    def interrupt(self) -> None:
        """End the current `wait`, or else the next. Any thread may call this."""
        if not self.closed:
            with suppress(OSError, ValueError):
                self._bell.ring()

    # ---- waiting

    def descriptor(self) -> int | None:
        """Return epoll's own descriptor, which is readable while a registered descriptor is ready."""
        return None if isinstance(self._poller, _Portable) else self._poller.fileno()

    def next_due(self) -> float:
        """Return when the next timer is due, on the monotonic clock."""
        return self._next_due

    def wait(self, timeout_ns: int) -> int:
        """Wait up to `timeout_ns`; return the number of events to `serve`, negative once the poller was
        closed.
        """
        if self.closed:
            return -1
        if self._unsent:
            self._send_unsent()
        timeout = timeout_ns * 1e-9
        left = self._next_due - monotonic()
        if left < timeout:
            timeout = left if left > 0 else 0.0
        events: list[tuple[int, int]] = []
        try:
            if timeout >= 1e6:
                events = self._poller.poll()
            elif timeout >= 0.002 or self._precise is None:
                events = self._poller.poll(timeout - 0.001 if self._precise else timeout)
            elif not timeout or select.select([self._precise], (), (), timeout)[0]:
                events = self._poller.poll(0)
        except (OSError, ValueError) as error:
            if self._is_gone():
                return -1
            if self._portable and isinstance(error, OSError):
                # select on Windows refuses a socket that was closed meanwhile; the next wait leaves it out
                return 0
            raise
        self._events = events
        return len(events) or self._next_due <= monotonic()

    def _is_gone(self) -> bool:
        """True if this poller was closed meanwhile."""
        return self.closed

    def serve(self, _found: int = 0) -> None:
        """Call the handlers of the events that the last `wait` has found, and the due timers."""
        handlers = self._handlers
        for fd, events in self._events:
            handler = handlers.get(fd)
            if handler is not None:
                try:
                    handler(events)
                except Exception as error:
                    report_failure(self._name, error)
        self._events = []
        if self._next_due <= monotonic():
            self._run_timers()

    def _run_timers(self) -> None:
        while (timer := self._take_due()) is not None:
            function, timer.function = timer.function, None
            self._run(function)

    def _take_due(self) -> Timer | None:
        """Take out the next due timer; None if none is due."""
        with self._lock:
            while self._timers:
                entry = heapq.heappop(self._timers)
                if entry[2].function is None:
                    self._cancelled -= 1
                elif entry[0] <= monotonic():
                    return entry[2]
                else:
                    heapq.heappush(self._timers, entry)
                    break
            self._next_due = float('inf')  # before the look: a timer that is set meanwhile may lower it
            if self._timers:
                self._next_due = min(self._next_due, self._timers[0][0])
        return None

    def _quiet(self, _events: int) -> None:
        self._bell.quiet()
        try:
            for _ in range(len(self._calls)):  # later calls ring the bell again
                self._run(self._calls.popleft())
        finally:
            if self._calls:  # a signal's handler raised: calls are left
                self.interrupt()

    def _run(self, function: Callable[[], None] | None) -> None:
        if function is not None:
            try:
                function()
            except Exception as error:
                report_failure(self._name, error)

    def close(self) -> None:
        """Close everything. No thread may wait in it any more. Idempotent."""
        self.closed = True
        self._precise = None
        self._handlers.clear()
        self._timers.clear()
        self._poller.close()
        self._bell.close()
