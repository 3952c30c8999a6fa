"""Calls a service."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar, cast

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.attempt import Attempt
from goalwire.entities.client import ClientCore, ResponseFuture, unanswered
from goalwire.entities.exceptions import InvalidHandle
from goalwire.errors import CallError

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.protocol.qos import QoS

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class _Core(ClientCore):
    """A client whose futures fail where nobody answers."""

    def on_unanswered(self, future: ResponseFuture) -> None:
        self.unanswered += 1
        future.set_exception(unanswered('request', future.reason))

    def destroy(self) -> None:
        for future in list(self.pending.values()):
            future.forget()
            future.set_exception(InvalidHandle())
        super().destroy()


class Client(Entity, Generic[RequestT, ResponseT]):
    """Made by Node.client."""

    def __init__(self, node: NodeCore, support: ServiceSupport, name: str, qos: QoS) -> None:
        self._core = _Core(node, support, name, qos)
        self.name = self._core.full_name

    async def call(
        self, request: RequestT | None = None, /, *, timeout: float | None = None, **fields: object
    ) -> ResponseT:
        """Wait for a server, send a request (or one made of `fields`), and wait for its response.

        All that within `timeout` s, if it is given. Raises NoServerError or DeadlineError when they are over,
        ServerLostError as soon as the server goes away, ServerFailedError where it gives the request up;
        InvalidHandle once closed, ShutDownError; TypeError and EncodeError for what is no such request.
        """
        core = self._core
        message = message_of(core.support.request, request, fields)
        attempt = self._attempt(timeout)
        await attempt.until(core.server_is_there, self.name)
        future = core.call_async(message)
        try:
            await attempt.settle(future)
            return cast('ResponseT', future.result())
        except CallError as error:
            raise attempt.retold(error) from None
        finally:
            cast('ResponseFuture', future).forget()

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        await self._attempt(timeout).until(self._core.server_is_there, self.name)

    def _attempt(self, timeout: float | None) -> Attempt:
        return Attempt(self._core.node.context, 'service', self.name, timeout)

    def close(self) -> None:
        """Call no more; calls that wait raise InvalidHandle. Idempotent."""
        self._core.destroy()
