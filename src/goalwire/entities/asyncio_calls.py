"""Service calls that coroutines under any asyncio loop wait for."""

from __future__ import annotations

import asyncio
from typing import Any

from goalwire.entities.client import ClientCore
from goalwire.entities.graph_waiting import graph_shows
from goalwire.entities.pending_call import PendingCall
from goalwire.errors import DestroyedError, ShutDownError
from goalwire.execution.asyncio.waiting import settle


class AwaitedCalls:
    """The calls of one client that are awaited. For the loop's thread alone."""

    def __init__(self, client: ClientCore) -> None:
        self._client = client
        self._waiting: set[PendingCall] = set()

    async def call(self, request: Any) -> Any:
        """Send a request and wait for its response, for ever where nobody answers.

        Raises CancelledError where `cancel` is called meanwhile, DestroyedError for a destroyed client,
        ShutDownError at shutdown; TypeError and EncodeError for what is no such request.
        """
        client = self._client
        if client.destroyed:
            raise DestroyedError(f"cannot call '{client.full_name}': the client was destroyed")
        future = client.begin(request, client.default_timeout)
        self._waiting.add(future)
        try:
            await settle(future, client.node.context.shutdown_signal)
        finally:
            self._waiting.discard(future)
            if not future.done():
                future.discard()
        if future.cancelled():
            raise asyncio.CancelledError(f"the client of '{client.full_name}' was destroyed")
        if future.pending():
            raise ShutDownError(f"no response of '{client.full_name}' came")
        try:
            return future.result()
        finally:
            del future  # its exception's traceback holds this frame

    async def until_served(self) -> None:
        """Wait until there is a server. Raises InvalidHandle where the client is destroyed, ShutDownError."""
        client = self._client
        if not await graph_shows(client.node.context, client.server_is_there):
            raise ShutDownError(f"no server of '{client.full_name}' came")

    def cancel(self) -> None:
        """Cancel the calls that wait, whether somebody may still answer them or not."""
        for future in tuple(self._waiting):
            future.cancel()
