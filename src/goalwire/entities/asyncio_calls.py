"""Service calls that a coroutine under any asyncio loop waits for."""

from __future__ import annotations

import asyncio
from typing import Any

from goalwire.entities.client import ClientCore, ResponseFuture
from goalwire.entities.exceptions import ShutDownError
from goalwire.entities.graph_waiting import graph_shows
from goalwire.errors import DestroyedError
from goalwire.execution.asyncio_waiting import settle


async def call(client: ClientCore, request: Any) -> Any:
    """Send a request and wait for its response, for ever where nobody answers.

    Raises CancelledError where `give_up` is called meanwhile, DestroyedError for a destroyed client,
    ShutDownError at shutdown; TypeError and EncodeError for what is no such request.
    """
    if client.destroyed:
        raise DestroyedError(f"cannot call '{client.full_name}': the client was destroyed")
    future = client.call_async(request)
    assert isinstance(future, ResponseFuture)
    try:
        await settle(future, client.node.context.lifeline)
    finally:
        if not future.done():
            future.forget()
    if future.cancelled():
        raise asyncio.CancelledError(f"the client of '{client.full_name}' was destroyed")
    if future.pending():
        raise ShutDownError(f"no response of '{client.full_name}' came")
    return future.result()


async def until_served(client: ClientCore) -> None:
    """Wait until there is a server. Raises InvalidHandle where the client is destroyed, ShutDownError."""
    if not await graph_shows(client.node.context, client.server_is_there):
        raise ShutDownError(f"no server of '{client.full_name}' came")


def give_up(client: ClientCore) -> None:
    """Cancel the calls that wait for their responses."""
    for future in list(client.pending.values()):
        future.cancel()
