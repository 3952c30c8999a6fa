"""rclpy.experimental.async_service: answers requests in an asyncio loop."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.transport.contract import Request
from rclpy.service import RequestT, ResponseT, Service


class AsyncService(Service[RequestT, ResponseT]):
    """Made by AsyncNode.create_service."""

    on_destroy: Callable[[], object] | None = None

    def send_response(self, response: object, header: Request) -> None:
        """Send the response; where the callback has destroyed its service or node, the client is told so."""
        if self.destroyed:
            header.drop('its service was destroyed')
        else:
            super().send_response(response, header)

    def destroy(self) -> None:
        """Undeclare, and cancel the callbacks that run, save one that calls this. Idempotent.

        Clients whose requests are not answered any more are told so.
        """
        super().destroy()
        if self.on_destroy is not None:
            self.on_destroy()
