"""Calls a service."""

from __future__ import annotations

import asyncio
from math import inf
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.call_context import CallContext
from goalwire.entities.client import ClientCore
from goalwire.execution.asyncio.waiting import completion, waker_of

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.rules.qos import QoS
    from goalwire.rules.retries import Retry
    from goalwire.rules.statistics import ClientStatistics

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class Client(Entity, Generic[RequestT, ResponseT]):
    """Made by Node.client."""

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        qos: QoS,
        timeout: float | None,
        retry: Retry | None,
    ) -> None:
        self._bridge = waker_of(asyncio.get_running_loop())
        self._core = ClientCore(node, support, name, qos)
        self._core.call_timeout = timeout
        if retry is not None:
            self._core.retry = retry
        self.name = self._core.full_name

    async def call(
        self, request: RequestT | None = None, /, *, timeout: float | None = None, **fields: object
    ) -> ResponseT:
        """Wait for a server, send a request (or one made of `fields`), and wait for its response.

        All that within `timeout` s; without, within that of the client, the node or the process, if one is
        given. Raises NoServerError or DeadlineError when they are over, ServerLostError as soon as the server
        goes away, ServerFailedError or RefusedError where it gives the request up; InvalidHandle once closed,
        ShutDownError, TooManyCallsError; TypeError and EncodeError for what is no such request.
        """
        core = self._core
        message = message_of(core.support.request, request, fields)
        limit = core.default_timeout if timeout is None else timeout
        future = core.begin(message, inf if limit is None else limit)
        if future.pending():
            try:
                await completion(future, self._bridge)
            except BaseException:
                future.discard()
                raise
        try:
            return future.result()  # type: ignore[return-value] # `cast` would be one function more to enter
        finally:
            del future  # its exception's traceback holds this frame

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        core = self._core
        attempt = CallContext(core.node.context, 'service', self.name, timeout)
        await attempt.until(core.server_is_there, self.name)

    def statistics(self) -> ClientStatistics:
        """Count what was sent, and what came of it."""
        return self._core.statistics()

    def close(self) -> None:
        """Call no more; calls that wait raise InvalidHandle. Idempotent."""
        self._core.destroy()
