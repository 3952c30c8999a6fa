"""The coroutine callbacks that are under way in an asyncio loop."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from goalwire.execution.callback_source import CallbackSource


class CallbackTasks:
    """Which tasks run the callbacks of which work. For the loop's thread alone."""

    def __init__(self) -> None:
        self._tasks: dict[asyncio.Task[Any], CallbackSource] = {}

    def __len__(self) -> int:
        return len(self._tasks)

    def add(self, task: asyncio.Task[Any], source: CallbackSource) -> None:
        """Note that `task` runs a callback of `work`."""
        self._tasks[task] = source

    def discard(self, task: asyncio.Task[Any]) -> None:
        """Forget a task that has ended."""
        self._tasks.pop(task, None)

    def cancel(self, source: CallbackSource) -> None:
        """Cancel the callbacks of `work`, save one that calls this: it may go on to its end."""
        self._cancel([task for task, its_work in self._tasks.items() if its_work is source])

    def cancel_all(self) -> None:
        """Cancel every callback, save one that calls this."""
        self._cancel(list(self._tasks))

    def _cancel(self, tasks: list[asyncio.Task[Any]]) -> None:
        if not tasks:
            return
        calling = asyncio.current_task()
        for task in tasks:
            if task is not calling:
                task.cancel()
