"""How coroutines wait: for a wake-up, a future, the next item of a queue, a function in a thread."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.execution.asyncio.loop_waker import DirectFuture, waker_of

if TYPE_CHECKING:
    from typing import Self

    from goalwire.execution.asyncio.loop_waker import Awaitable, LoopWaker
    from goalwire.execution.shutdown_signal import ShutdownSignal

_MS = 1_000_000
"""One millisecond in ns."""


def delay_s(missing_ns: int) -> float:
    """Return the delay in s with which `call_later` calls no earlier than in `missing_ns`.

    Loops wake in whole milliseconds (epoll, libuv), and libuv rounds down. So this rounds up.
    """
    return max(-(-missing_ns // _MS), 0) / 1e3


class AsyncWaiter:
    """A place for one coroutine to sleep in, as `Waiter` is for a thread.

    It holds at most one wake-up. `wake` sets `_woken`, then looks for the sleeper. `wait` sets the sleeper,
    then looks at `_woken`. So one of the two sees the other.
    """

    __slots__ = ('_loop', '_sleeper', '_waker', '_woken')

    def __init__(self) -> None:
        """Make a waiter for the running loop; raises RuntimeError if no loop runs."""
        self._loop = asyncio.get_running_loop()
        self._waker = waker_of(self._loop)
        self._sleeper: DirectFuture | None = None
        self._woken = False

    def wake(self) -> None:
        """End the current or the next `wait`. Callable from any thread and from signal handlers; takes no
        lock.
        """
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
    """Wait until `future` is done (True), or until the shutdown begins or the context's clock reaches
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
    """Return an awaitable that ends when `future` is no longer pending; `waker` is the running loop's.

    It takes no waker back from `future`. So `future` must end in any case: if the awaiting coroutine is
    cancelled, the caller must cancel `future`, too.
    """
    direct = DirectFuture()
    future.add_waker(partial(waker.call, direct.resume))
    return direct


T = TypeVar('T')

_BURST = 64
"""The number of items that one coroutine may take in a row before other coroutines have their turn."""


class AsyncQueue(Generic[T]):
    """A queue that coroutines read by `async for`. Each item goes to one reader, in order.

    `depth` items wait at most (None: without limit); beyond that, the oldest is dropped and counted in
    `dropped`. `deliver` appends its item, then looks for sleepers; a reader puts itself into the sleepers,
    then looks for items. So one of the two sees the other.
    """

    def __init__(self, depth: int | None = None) -> None:
        """Make a queue for the running loop; raises RuntimeError if no loop runs."""
        self._loop = asyncio.get_running_loop()
        self._waker = waker_of(self._loop)
        self._items: deque[T] = deque(maxlen=depth)
        self._sleepers: list[DirectFuture] = []
        self.closed = False
        self._in_a_row = 0
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._items)

    def deliver(self, item: T) -> None:
        """Queue an item, unless the queue is closed. Callable from any thread."""
        if self.closed:
            return
        if len(self._items) == self._items.maxlen:
            self.dropped += 1
        self._items.append(item)
        if self._sleepers:
            self._wake()

    def close(self) -> None:
        """End the queue: the waiting items are given out, then `async for` ends. Callable from any thread;
        idempotent.
        """
        self.closed = True
        self._wake()

    def discard(self) -> None:
        """End the queue, and discard the waiting items. Only on the loop's thread."""
        self.close()
        self._items.clear()

    def _wake(self) -> None:
        while self._sleepers:
            try:
                sleeper = self._sleepers.pop(0)
            except IndexError:
                return  # another thread wakes the sleeper
            self._waker.call(sleeper.resume)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        """Wait for the next item. Raises StopAsyncIteration once the queue is closed and empty."""
        items = self._items
        self._in_a_row += 1
        if self._in_a_row > _BURST:
            self._in_a_row = 0
            await asyncio.sleep(0)
        while not items:
            if self.closed:
                raise StopAsyncIteration
            self._in_a_row = 0
            direct = DirectFuture(loop=self._loop)
            self._sleepers.append(direct)
            if items or self.closed:
                self._leave(direct)
                continue
            try:
                await direct
            except BaseException:
                self._leave(direct)
                raise
        return items.popleft()

    def _leave(self, direct: DirectFuture) -> None:
        with suppress(ValueError):  # not there: a wake-up has taken it out
            self._sleepers.remove(direct)


async def in_thread(function: Callable[[], T]) -> T:
    """Call `function` in a thread and return its result, or raise its error.

    A thread cannot be stopped. So a cancellation is raised after the function has ended: no work is left half
    done.
    """
    source = asyncio.ensure_future(asyncio.to_thread(function))
    cancellation: asyncio.CancelledError | None = None
    while not source.done():
        try:
            await asyncio.wait([source])
        except asyncio.CancelledError as error:
            cancellation = error
    if cancellation is None:
        return source.result()
    source.exception()  # read, so that asyncio does not log it as never retrieved
    raise cancellation
