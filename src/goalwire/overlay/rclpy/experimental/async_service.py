"""rclpy.experimental.async_service: answers requests in an asyncio loop."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.service import RequestT, ResponseT, Service


class AsyncService(Service[RequestT, ResponseT]):
    """Made by AsyncNode.create_service."""

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """Undeclare, and cancel the callbacks that run, save one that calls this. Idempotent.

        Clients whose requests are not answered any more are told so.
        """
        super().destroy()
        if self.on_destroy is not None:
            self.on_destroy()
