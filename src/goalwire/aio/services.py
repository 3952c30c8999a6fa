"""Service clients and servers of the asyncio API."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from math import inf
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.call_deadlines import CallContext
from goalwire.entities.client import ClientCore
from goalwire.entities.service import ServiceCore
from goalwire.execution.asyncio.loop_waker import waker_of
from goalwire.execution.asyncio.waiting import completion
from goalwire.execution.callback_arguments import check_callback
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.logging import get_logger

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.execution.asyncio.executor import CallbackTasks
    from goalwire.rules.qos import QoS
    from goalwire.rules.retries import Retry
    from goalwire.rules.statistics import ClientStatistics, ServiceStatistics


RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class Client(Entity, Generic[RequestT, ResponseT]):
    """Calls one service. Made by Node.client."""

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
        """Wait for a server, send a request, given or made of `fields`, and wait for its response.

        `timeout` s is the limit for all of this; by default the timeout of the client, the node or the
        process counts, if there is one. Raises NoServerError or DeadlineError after that time,
        ServerLostError as soon as the server has gone, ServerFailedError or RefusedError if the server does
        not answer the request; InvalidHandle once closed, ShutDownError, TooManyCallsError; TypeError and
        EncodeError for a wrong request.
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
            return future.result()  # type: ignore[no-any-return]  # `cast` would be one function more to enter
        finally:
            del future  # breaks a reference cycle: the exception's traceback holds this frame

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        core = self._core
        attempt = CallContext(core.node.context, 'service', self.name, timeout)
        await attempt.until(core.server_is_there, self.name)

    def statistics(self) -> ClientStatistics:
        """Return the counts of requests sent, and of their outcomes."""
        return self._core.statistics()

    def close(self) -> None:
        """Stop calling; waiting calls raise InvalidHandle. Idempotent."""
        self._core.destroy()


class LoggedService(ServiceCore):
    """A service whose callback may fail: the error is logged, and the client gets an error."""

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos: QoS,
        *,
        concurrent: bool,
    ) -> None:
        """`callback(request, response)` returns the response, or a coroutine that does."""
        self.failed = self._log
        group = ReentrantCallbackGroup() if concurrent else MutuallyExclusiveCallbackGroup()
        super().__init__(node, support, name, callback, qos, group)

    def _log(self, error: Exception) -> None:
        if self.destroyed:
            return  # the service was closed before its handler failed
        from goalwire.tracebacks import traceback_text

        get_logger(self.node.logger_name).error(
            f"Service '{self.full_name}': its handler failed\n{traceback_text(error)}"
        )


class Service(Entity, Generic[RequestT, ResponseT]):
    """Serves one service. Made by Node.service."""

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        handler: Callable[[RequestT], ResponseT | Awaitable[ResponseT]],
        qos: QoS,
        runs: CallbackTasks,
        *,
        concurrent: bool,
    ) -> None:
        check_callback(handler, ('request',), f"the handler of the service '{name}'")

        def answer(request: Any, _response: object) -> object:
            return handler(request)

        self._core = LoggedService(node, support, name, answer, qos, concurrent=concurrent)
        self._runs = runs
        self.name = self._core.full_name

    def statistics(self) -> ServiceStatistics:
        """Return the counts of requests received, and of their outcomes."""
        return self._core.statistics()

    def close(self) -> None:
        """Stop answering. Running handlers are cancelled, and their clients get an error. Idempotent."""
        self._core.destroy()
        self._runs.cancel(self._core.event_queue)
