"""How any thread wakes a task of an asyncio loop: in one turn of the loop, and many with one system call.

asyncio's own way (`call_soon_threadsafe(future.set_result, …)`) takes a handle, a write to a socket, two
reads of it, and two turns of the loop. Here a task sleeps in a `Pause`, which goes on as soon as the loop
hears of it, and a loop that runs a node listens to an eventfd: to another thread and back takes 11.5 us, not
17 (and under uvloop as much as asyncio's own).
"""

from __future__ import annotations

import asyncio
import os
import select
from collections import deque
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from typing import TYPE_CHECKING
from weakref import ref

from goalwire.execution.loop_waker import WAKE_FDS

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextvars import Context
    from typing import Any

_RINGER_MS = 1000
"""How long closing waits for a thread that is about to ring: microseconds."""


class DirectFuture(asyncio.Future[None]):
    """Where one task sleeps until `resume`, or until it is cancelled.

    The task goes on inside `resume`, not a turn of the loop later, as with a plain future.
    """

    _wakeup: Callable[[Any], object] | None = None
    _context: Context

    def add_done_callback(
        self, wakeup: Callable[[Any], object], /, *, context: Context | None = None
    ) -> None:
        """Keep what the task goes on by: asyncio calls this when the task goes to sleep here."""
        self._wakeup = wakeup
        self._context = copy_context() if context is None else context

    def resume(self) -> None:
        """Let the task go on, if it still sleeps here. On the loop's thread alone, outside of tasks."""
        if self.done():
            return
        self.set_result(None)
        wakeup, self._wakeup = self._wakeup, None  # the task holds this
        if wakeup is not None:
            self._context.run(wakeup, self)

    def cancel(self, msg: Any | None = None) -> bool:
        """Let the task go on with a CancelledError in the loop's next turn: it calls this when cancelled."""
        if not super().cancel(msg):
            return False
        wakeup, self._wakeup = self._wakeup, None
        if wakeup is not None:
            self.get_loop().call_soon(wakeup, self, context=self._context)
        return True


class LoopWaker:
    """Calls functions from any thread on the thread of one asyncio loop, many with one wake-up.

    Who calls appends, then looks whether the loop sleeps, and rings where it does. The loop says that it
    sleeps, then looks for calls: one of them sees the other. `pop` gives the item of `asleep` to one thread:
    that one rings, and the loop answers, even where it has found the call before it was rung.
    """

    __slots__ = ('__weakref__', '_next_ring', '_ring', 'asleep', 'calls')

    direct = DirectFuture
    """Here, since to import it where somebody waits takes longer than to make one."""

    def __init__(self, ring: Callable[[], object]) -> None:
        """`ring` gets `answer` called soon on the loop's thread; it may be called on any thread."""
        self._ring = self._next_ring = ring
        self.calls: deque[Callable[[], object]] = deque()
        """What `answer` is to call."""
        self.asleep: list[None] = [None]
        """Not empty while who calls is to ring."""

    def call(self, function: Callable[[], object]) -> None:
        """Call `function()` soon, on the loop's thread and outside of its tasks. Any thread.

        Nothing where the loop is closed.
        """
        self.calls.append(function)
        if self.asleep:
            try:
                self.asleep.pop()
            except IndexError:
                return  # another thread rings
            self._ring()

    def answer(self) -> None:
        """Do what was asked for until now; on the loop's thread.

        What the functions raise comes out (it ends the program), and the others have their turn later.
        """
        self._ring = self._next_ring  # nobody is about to ring now
        self.asleep.append(None)
        calls = self.calls
        try:
            for _ in range(len(calls)):
                calls.popleft()()
        except BaseException:
            if calls:
                self.call(_nothing)
            raise


def _nothing() -> None:
    """What is called for the wake-up's sake."""


class AsyncioLoopWaker(LoopWaker):
    """To a loop that is none of ours: over `call_soon_threadsafe` or, while this is open, an eventfd."""

    __slots__ = ('_loop', '_users', '_wake_fd')

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(self._ask_loop)
        self._loop = ref(loop)  # who keeps bridges keeps them by loop, weakly
        self._users = 0
        self._wake_fd = -1

    def open(self) -> None:
        """Listen to an eventfd until as many `close`, where there is such a thing. The loop's thread."""
        self._users += 1
        loop = self._loop()
        if self._wake_fd >= 0 or loop is None or not hasattr(os, 'eventfd'):
            return
        with suppress(OSError, NotImplementedError):  # too many files are open, or the loop watches none
            wake_fd = os.eventfd(0, os.EFD_CLOEXEC | os.EFD_NONBLOCK)
            try:
                loop.add_reader(wake_fd, self._rung)
            except BaseException:
                os.close(wake_fd)
                raise
            self._wake_fd = wake_fd
            WAKE_FDS.add(wake_fd)
            self._change_ring(partial(os.eventfd_write, wake_fd, 1))

    def close(self) -> None:
        """Go back to `call_soon_threadsafe` with the last who has opened this. The loop's thread."""
        self._users -= 1
        wake_fd, loop = self._wake_fd, self._loop()
        if self._users or wake_fd < 0 or loop is None:
            return
        self._wake_fd = -1
        loop.remove_reader(wake_fd)
        WAKE_FDS.discard(wake_fd)
        rings_bell = self._ring != self._ask_loop
        if self._change_ring(self._ask_loop) or not rings_bell:
            os.close(wake_fd)
            return
        hearing = select.poll()
        hearing.register(wake_fd, select.POLLIN)
        if hearing.poll(_RINGER_MS):  # a thread has rung it, or is about to
            os.close(wake_fd)
        loop.call_soon(self.answer)

    def _change_ring(self, ring: Callable[[], object]) -> bool:
        """Ring that way, at once (True) or, where somebody may be ringing now, from the next answer on."""
        self._next_ring = ring
        try:
            self.asleep.pop()
        except IndexError:
            return False
        self._ring = ring
        self.asleep.append(None)
        if self.calls:
            self.call(_nothing)
        return True

    def _ask_loop(self) -> None:
        loop = self._loop()
        with suppress(RuntimeError):
            if loop is not None:
                loop.call_soon_threadsafe(self.answer)
                return
        self.calls.clear()  # the loop is closed: nobody waits there any more
        self.asleep.append(None)

    def _rung(self) -> None:
        os.eventfd_read(self._wake_fd)
        self.answer()
