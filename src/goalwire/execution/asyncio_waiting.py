"""How a coroutine under any asyncio loop sleeps until somebody, on whichever thread, wakes it."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

from goalwire.execution.asyncio_loop_waker import DirectFuture
from goalwire.execution.loop_waker import waker_of

if TYPE_CHECKING:
    from goalwire.execution.asyncio_loop_waker import LoopWaker
    from goalwire.execution.loop_waker import Awaitable
    from goalwire.execution.shutdown_signal import ShutdownSignal


_MS = 1_000_000
"""ns."""


def delay_s(missing_ns: int) -> float:
    """What to tell `call_later`, to be called no earlier than in `missing_ns`.

    Loops wake in whole milliseconds (epoll, libuv), and libuv rounds down: so up here.
    """
    return max(-(-missing_ns // _MS), 0) / 1e3


class AsyncWaiter:
    """A place for one coroutine to sleep in: what `Waiter` is for a thread.

    It holds at most one wake-up. Who wakes notes that, then looks for the sleeper; who goes to sleep shows
    itself, then looks at the note: one of them sees the other.
    """

    __slots__ = ('_loop', '_sleeper', '_waker', '_woken')

    def __init__(self) -> None:
        """Belongs to the running loop; raises RuntimeError outside one."""
        self._loop = asyncio.get_running_loop()
        self._waker = waker_of(self._loop)
        self._sleeper: DirectFuture | None = None
        self._woken = False

    def wake(self) -> None:
        """End the current or the next `wait`. Any thread, signal handlers too; takes no lock."""
        self._woken = True
        sleeper = self._sleeper
        if sleeper is not None:
            self._waker.call(sleeper.resume)

    async def wait(self, timeout_ns: int | None = None) -> None:
        """Sleep until woken, or for `timeout_ns`."""
        self._sleeper = direct = DirectFuture(loop=self._loop)
        timer = None if timeout_ns is None else self._loop.call_later(delay_s(timeout_ns), direct.resume)
        try:
            if not self._woken:
                await direct
        finally:
            self._sleeper = None
            if timer is not None:
                timer.cancel()
        self._woken = False


async def settle(future: Awaitable, shutdown_signal: ShutdownSignal, deadline: int | None = None) -> bool:
    """Wait until `future` is no longer pending (True), or the shutdown has begun or its clock shows
    `deadline` (False).
    """
    if not future.pending():
        return True
    loop = asyncio.get_running_loop()
    direct = DirectFuture(loop=loop)
    wake = partial(waker_of(loop).call, direct.resume)
    watch = shutdown_signal.watch(wake)
    future.add_waker(wake)
    timer = None
    if deadline is not None:
        timer = loop.call_later(delay_s(deadline - shutdown_signal.clock.now()), direct.resume)
    try:
        await direct
    finally:
        if timer is not None:
            timer.cancel()
        future.remove_waker(wake)
        watch.close()
    return not future.pending()


def completion(future: Awaitable, waker: LoopWaker) -> DirectFuture:
    """Return what a coroutine awaits until `future`, which ends in any case, is no longer pending.

    `bridge` leads to the running loop. Where the coroutine is cancelled, the future must be given up.
    """
    direct = DirectFuture()
    future.add_waker(partial(waker.call, direct.resume))
    return direct
