"""The calls and goals of one client, which end when the client disconnects."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.permissions import Permissions
from goalwire.errors import NotAllowedError

MOST_UNDER_WAY = 1000
"""The most calls and goals of one client at a time."""


class ClientTasks:
    """The base of each protocol's client: it has the tasks of that client."""

    def __init__(self, hub: Hub, permissions: Permissions) -> None:
        self.hub = hub
        self.permissions = permissions
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self, work: Coroutine[Any, Any, None], *, outlives: bool = False) -> None:
        """Run a coroutine as a task. When the client is lost, cancel the task unless `outlives` is True.

        Raises NotAllowedError if the client has too many tasks.
        """
        if len(self._tasks) >= MOST_UNDER_WAY:
            work.close()
            raise NotAllowedError(f'{MOST_UNDER_WAY} calls and goals of this client are under way: wait')
        task = self.hub.start(work)
        if not outlives:
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def end_tasks(self) -> None:
        """Cancel this client's tasks, and wait until they have cleaned up."""
        for task in self._tasks:
            task.cancel()
        while self._tasks:
            await asyncio.wait(self._tasks)
