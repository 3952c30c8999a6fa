"""An asyncio loop reads the wire itself, without a thread in between, if the session has a descriptor.

A thread that reads for the loop costs two wake-ups, its own and the loop's. If the loop's thread is busy for
long, the session's own thread reads (`concurrency/leader_followers.py`).
"""

from __future__ import annotations

import os
from asyncio import AbstractEventLoop, TimerHandle
from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from goalwire.execution.asyncio.loop_waker import WAKE_FDS, LoopWaker, shared_waker
from goalwire.execution.time.steady_clock import STEADY

if TYPE_CHECKING:
    from goalwire.concurrency.wire_poller import WirePoller

NEVER = float('inf')

_readers: WeakKeyDictionary[AbstractEventLoop, dict[int, WireReader]] = WeakKeyDictionary()


def read_wire(loop: AbstractEventLoop, wire_poller: WirePoller | None) -> Callable[[], None] | None:
    """Have the running loop read a wire, and return the function that ends the reading.

    Returns None if the wire or the loop does not support that. If several users read the same wire, the
    reading ends when the last of them ends it.
    """
    _release_closed_loops()
    if wire_poller is None:
        return None
    of_loop = _readers.setdefault(loop, {})
    reader = of_loop.get(id(wire_poller))
    if reader is None:
        reader = WireReader(loop, wire_poller)
        if not reader.open():
            return None
        of_loop[id(wire_poller)] = reader
    reader.users += 1
    return reader.leave


def _release_closed_loops() -> None:
    """Stop the readers of loops that were closed earlier than their nodes."""
    for key in _readers.keyrefs():  # copied, since other threads may add loops
        loop = key()
        if loop is not None and loop.is_closed():
            for reader in _readers.pop(loop, {}).values():
                reader.stop()


class WireReader:
    """Reads one wire on one asyncio loop. Only the loop's thread uses a reader, until the loop is closed."""

    def __init__(self, loop: AbstractEventLoop, wire_poller: WirePoller) -> None:
        self.users = 0
        self._loop = loop
        self._wire_poller = wire_poller
        self._waker: LoopWaker = shared_waker(loop)
        self._thread = get_ident()
        self._fd = -1
        self._due = NEVER
        self._timer: TimerHandle | None = None

    def open(self) -> bool:
        """Begin to read; False if the wire or the loop does not support that."""
        fd = self._wire_poller.attach_loop()
        if fd is None:
            return False
        try:
            self._loop.add_reader(fd, self._read)
        except BaseException as error:
            self._wire_poller.detach_loop(self._thread)
            os.close(fd)
            if isinstance(error, NotImplementedError):  # this loop cannot watch descriptors
                return False
            raise
        self._fd = fd
        WAKE_FDS.add(fd)
        self._loop.call_soon(self._read)  # the first read sets the timer for the wire's next due time
        return True

    def leave(self) -> None:
        """Stop reading, once the last user has left."""
        self.users -= 1
        if self.users or self._fd < 0:
            return
        _readers[self._loop].pop(id(self._wire_poller), None)
        self.stop()

    def stop(self) -> None:
        """Stop reading. To be called on the loop's thread or, once the loop is closed, on any thread."""
        fd, self._fd = self._fd, -1
        self._loop.remove_reader(fd)
        WAKE_FDS.discard(fd)
        os.close(fd)
        if self._timer is not None:
            self._timer.cancel()
        self._wire_poller.detach_loop(self._thread)

    def _read(self) -> None:
        if self._fd >= 0:
            self._waker.gather(self._serve)

    def _serve(self) -> None:
        due = self._wire_poller.serve_ready()
        if due != self._due:
            self._due = due
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None
            if due != NEVER and self._fd >= 0:
                self._timer = self._loop.call_later(max(due - STEADY.now() / 1e9, 0) + 0.001, self._ring)

    def _ring(self) -> None:
        self._timer, self._due = None, NEVER
        self._read()
