"""The launch's own node, `launch_ros_<pid>`, for actions that talk to other nodes.

The first action that needs the node opens it. It runs in the launch's loop and closes at the launch's end.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Coroutine
from typing import Any

from goalwire.errors import LaunchError
from goalwire.launching.errors import as_sentence
from goalwire.launching.model import LaunchContext

_GLOBAL = 'launch_node'


class LaunchNode:
    """The launch's node, its clients, and the tasks that use them."""

    def __init__(self, context: LaunchContext) -> None:
        self.context = context
        self._stop = asyncio.Event()
        self._node: asyncio.Future[Any] = context.asyncio_loop.create_future()
        self._tasks: set[asyncio.Task[None]] = set()
        self._clients: dict[str, Any] = {}
        self._life = context.asyncio_loop.create_task(self._live())
        context.async_cleanups.append(self.close)

    @classmethod
    def of(cls, context: LaunchContext) -> LaunchNode:
        """Return the launch's node; the first call opens it."""
        found = context.get_globals().get(_GLOBAL)
        if not isinstance(found, LaunchNode):
            found = cls(context)
            context.extend_globals({_GLOBAL: found})
        return found

    async def _live(self) -> None:
        from goalwire.aio import Node

        try:  # `name:=value` on the command line is a launch argument, not a remapping
            async with Node(f'launch_ros_{os.getpid()}', program_arguments=False) as node:
                self._node.set_result(node)
                await self._stop.wait()
        except Exception as error:
            if not self._node.done():
                self._node.set_exception(LaunchError(f"the launch's own node: {as_sentence(error)}"))

    async def wait_open(self) -> Any:
        """Return the `goalwire.Node` once it is open. Raises LaunchError if it cannot be opened."""
        return await asyncio.shield(self._node)

    async def client(self, service: type, name: str) -> Any:
        """Return the client of a service; calls with the same name share one client."""
        node = await self.wait_open()
        if name not in self._clients:
            self._clients[name] = node.client(service, name)
        return self._clients[name]

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Run a coroutine that uses the node; the end of the launch cancels it."""
        task = self.context.asyncio_loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def close(self) -> None:
        """Cancel the tasks that use the node, and close the node."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._stop.set()
        await self._life
        self.context.remove_globals([_GLOBAL])
        if self._node.done() and not self._node.cancelled():
            self._node.exception()  # asyncio shall not log the error as unretrieved
