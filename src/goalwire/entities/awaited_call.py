"""One call or goal of a coroutine, from beginning to deadline: how it waits, and what its errors tell."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from goalwire.entities.call_context import CallContext
from goalwire.entities.graph_waiting import graph_shows
from goalwire.errors import DeadlineError
from goalwire.execution.asyncio_waiting import settle

if TYPE_CHECKING:
    from goalwire.execution.loop_waker import Awaitable


class AwaitedCall(CallContext):
    """Terms that a coroutine waits on."""

    __slots__ = ()

    async def until(self, is_there: Callable[[], bool], served_as: str) -> None:
        """Wait for a server; see `see_servers`. Raises NoServerError at the deadline, ShutDownError."""
        if not await graph_shows(self.context, is_there, self.deadline):
            self.check_alive()
            raise self.no_server()
        self.see_servers(served_as)

    async def shows(self, predicate: Callable[[], bool], problem: str) -> None:
        """Wait until the graph looks as wanted. Raises DeadlineError, ShutDownError."""
        if not await graph_shows(self.context, predicate, self.deadline):
            self.check_alive()
            raise self.error(DeadlineError, problem)

    async def settle(self, future: Awaitable) -> None:
        """Wait until `future` is no longer pending. Raises DeadlineError, ShutDownError."""
        if not await settle(future, self.context.shutdown_signal, self.deadline):
            self.check_alive()
            raise self.error(DeadlineError, 'no answer came in time')
