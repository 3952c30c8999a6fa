"""rclpy.experimental.async_client: calls services from an asyncio loop."""

from __future__ import annotations

from typing import cast

from goalwire.entities.client import AwaitedCalls
from goalwire.entities.type_support import RequestT, ResponseT
from rclpy.client import BaseClient
from rclpy.impl.endpoint import Adopted


class AsyncClient(Adopted, BaseClient[RequestT, ResponseT]):
    """Calls one service. Made by AsyncNode.create_client."""

    calls: AwaitedCalls

    async def call(self, request: RequestT) -> ResponseT:  # type: ignore[override]  # rclpy's name for it
        """Send a request and wait for its response, without a time limit: to set one, use asyncio.timeout.

        Raises CancelledError if the client is destroyed meanwhile, RuntimeError if it was destroyed before,
        ShutDownError at shutdown; TypeError and EncodeError for an invalid request.
        """
        return cast('ResponseT', await self.calls.call(request))

    async def wait_for_service(self, *, check_interval: float = 0.1) -> None:  # type: ignore[override]
        """Wait until there is a server.

        Each change of the graph wakes this coroutine, so `check_interval` has no effect.

        Raises InvalidHandle if the client is destroyed, ShutDownError at shutdown.
        """
        await self.calls.until_served()

    def destroy(self) -> None:
        """Remove the client from the graph, and cancel the calls that wait for responses. Idempotent."""
        self.calls.cancel()
        super().destroy()
