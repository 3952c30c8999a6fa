"""A queue from any thread to the coroutines of one asyncio loop, which end when it does."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.execution.asyncio_loop_waker import DirectFuture
from goalwire.execution.loop_waker import waker_of

if TYPE_CHECKING:
    from typing import Self

T = TypeVar('T')

_BURST = 64
"""Items that one coroutine may take in a row before others have their turn."""


class AsyncQueue(Generic[T]):
    """`async for` gives what is delivered, in order, to one of those who wait.

    `depth` items wait at most (None: without limit); beyond it the oldest is dropped, and counted. Who
    delivers appends, then looks for sleepers; who goes to sleep shows itself, then looks for items.
    """

    def __init__(self, depth: int | None = None) -> None:
        """Belongs to the running loop; raises RuntimeError outside one."""
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
        """Queue an item. Any thread; one that is closed ignores it."""
        if self.closed:
            return
        if len(self._items) == self._items.maxlen:
            self.dropped += 1
        self._items.append(item)
        if self._sleepers:
            self._wake()

    def close(self) -> None:
        """End: what waits is still given out, then `async for` ends. Any thread; idempotent."""
        self.closed = True
        self._wake()

    def discard(self) -> None:
        """End, and give out nothing more, not even what waits. The loop's thread alone."""
        self.close()
        self._items.clear()

    def _wake(self) -> None:
        while self._sleepers:
            try:
                sleeper = self._sleepers.pop(0)
            except IndexError:
                return  # another thread wakes it
            self._waker.call(sleeper.resume)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        """Wait for the next item. Raises StopAsyncIteration once closed and empty."""
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
        with suppress(ValueError):  # it was woken
            self._sleepers.remove(direct)
