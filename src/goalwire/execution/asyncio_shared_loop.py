"""A block in which the running asyncio loop runs a node's callbacks: the ground of every asyncio front."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Self

from goalwire.execution.asyncio_executor import AsyncExecutor

if TYPE_CHECKING:
    from types import TracebackType

    from goalwire.execution.asyncio_callback_tasks import CallbackTasks
    from goalwire.execution.node_work_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal


class SharedLoop:
    """`async with` it, once. Errors of callbacks behave as those of tasks in an asyncio.TaskGroup.

    An error cancels the body and the other callbacks, and leaves the block in an ExceptionGroup. Leaving the
    block cancels the callbacks that run and waits until they have cleaned up.
    """

    def __init__(
        self, work_queue: NodeWorkQueue, shutdown_signal: ShutdownSignal, runs: CallbackTasks
    ) -> None:
        """`runs` is where the coroutine callbacks under way are noted."""
        self._runs = runs
        self._work_queue = work_queue
        self._shutdown_signal = shutdown_signal
        self._tasks: asyncio.TaskGroup | None = None
        self._engine: AsyncExecutor | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._over = asyncio.Event()

    @property
    def running(self) -> bool:
        """Whether the block has been entered and not left."""
        return self._tasks is not None

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._tasks = await asyncio.TaskGroup().__aenter__()
        self._engine = AsyncExecutor(
            self._work_queue, self._shutdown_signal, self._tasks, self._runs, self._over.set
        )
        self._engine.open()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._tasks is not None
        assert self._engine is not None
        try:
            self._engine.close()
            self._runs.cancel_all()
            await self._tasks.__aexit__(kind, error, trace)
        finally:
            self._tasks = self._engine = self._loop = None

    async def wait(self) -> None:
        """Return after `end`, or when the shutdown has begun."""
        await self._over.wait()

    def end(self) -> None:
        """Let `wait` return. Any thread."""
        loop = self._loop
        if loop is None:
            self._over.set()
        else:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(self._over.set)
