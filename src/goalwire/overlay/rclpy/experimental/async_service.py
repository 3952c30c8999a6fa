"""rclpy.experimental.async_service: answers requests in an asyncio loop."""

from __future__ import annotations

from goalwire.entities.type_support import RequestT, ResponseT
from goalwire.transport.contract import Request
from rclpy.impl.endpoint import Adopted
from rclpy.service import Service


class AsyncService(Adopted, Service[RequestT, ResponseT]):
    """Serves one service. Made by AsyncNode.create_service."""

    def send_response(self, response: object, header: Request) -> None:
        """Send the response.

        If the callback has destroyed the service or the node, the client gets an error.
        """
        if self.destroyed:
            header.cancel('its service was destroyed')
        else:
            super().send_response(response, header)
