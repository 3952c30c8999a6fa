"""Answers requests."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.aio.entity import Entity
from goalwire.entities.service import ServiceCore
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.execution.callbacks import check_callback
from goalwire.logging import get_logger

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.execution.asyncio.executor import CallbackTasks
    from goalwire.rules.qos import QoS
    from goalwire.rules.statistics import ServiceStatistics

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class LoggedService(ServiceCore):
    """A service whose callback may fail: that is logged, its client learns of it, the node goes on."""

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
            return  # an answer that came too late
        from goalwire.logging.tracebacks import traceback_text

        get_logger(self.node.logger_name).error(
            f"Service '{self.full_name}': its handler failed\n{traceback_text(error)}"
        )


class Service(Entity, Generic[RequestT, ResponseT]):
    """Made by Node.service."""

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
        """Count what was asked, and what came of it."""
        return self._core.statistics()

    def close(self) -> None:
        """Answer no more; handlers that run are cancelled, and their clients learn of it. Idempotent."""
        self._core.destroy()
        self._runs.cancel(self._core.event_queue)
