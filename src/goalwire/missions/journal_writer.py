"""Writes the journal on a thread of its own, so that a slow disk does not hold up the loop.

Changes that come while a commit is under way go into the next one together.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

from goalwire.errors import ClosedError, JournalError

if TYPE_CHECKING:
    from goalwire.missions.journal_store import Change, Store
    from goalwire.missions.this_computer import ThisComputer

T = TypeVar('T')


class Writer:
    """A runner's only access to its store. One loop uses it."""

    def __init__(self, store: Store, computer: ThisComputer) -> None:
        self.store = store
        self._computer = computer
        self._thread = ThreadPoolExecutor(1, 'goalwire-journal')
        self._waiting: list[Change] = []
        self._commit: asyncio.Task[None] | None = None
        self._next: asyncio.Task[None] | None = None
        self._is_closed = False
        self.failure: asyncio.Future[JournalError] = asyncio.get_running_loop().create_future()
        """The error of the first change that could not be written: its mission cannot go on."""

    async def write(self, change: Change) -> None:
        """Write a change, and return when it is on the disk. Raises JournalError."""
        self._waiting.append(change)
        if self._next is None:
            self._next = asyncio.ensure_future(self._commit_next(self._commit))
        await asyncio.shield(self._next)

    async def _commit_next(self, before: asyncio.Task[None] | None) -> None:
        if before is not None:
            await asyncio.wait([before])
        self._commit, self._next = self._next, None
        changes, self._waiting = self._waiting, []
        try:
            await self.run(lambda: self.store.commit(changes, self._computer.wall()))
        except JournalError as error:
            if not self.failure.done():
                self.failure.set_result(error)
            raise

    async def run(self, function: Callable[[], T]) -> T:
        """Call a function on the writer's thread, which may use the store. Raises ClosedError."""
        if self._is_closed:
            raise ClosedError("the missions' runner has ended: its journal is closed")
        return await asyncio.get_running_loop().run_in_executor(self._thread, function)

    async def close(self) -> None:
        """Wait for what is being written, then close the store. Idempotent."""
        under_way = [task for task in (self._commit, self._next) if task is not None]
        if under_way:
            await asyncio.wait(under_way)
            for task in under_way:
                task.exception()  # read the error, or asyncio logs it: each waiting caller gets it
        self._is_closed = True
        self._thread.shutdown()
        self.store.close()
