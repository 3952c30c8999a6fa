"""A service server: calls its callback with each request, and sends the answer once."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import TYPE_CHECKING, Any

from goalwire.entities.coroutines import Answering
from goalwire.entities.node import NodeCore
from goalwire.entities.recorder_watch import watch_recorders
from goalwire.entities.request_server import RequestServer
from goalwire.entities.service_introspection import Introspected, ServiceIntrospection, Step
from goalwire.entities.type_support import ServiceSupport
from goalwire.errors import InvalidHandle
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.places import at, function_place
from goalwire.rules import reasons
from goalwire.rules.latencies import Latencies
from goalwire.rules.qos import QoS
from goalwire.transport.contract import Request

if TYPE_CHECKING:
    from goalwire.rules.statistics import ServiceStatistics


class ServiceCore(Introspected):
    """Answers requests of one service: `callback(request, response)` returns the response or a coroutine."""

    failed: Callable[[Exception], None] | None = None
    """Gets the error of the callback, once the request is cancelled; None: the error comes out of spin."""

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        callback: Callable[[Any, Any], object],
        qos: QoS,
        group: CallbackGroup,
    ) -> None:
        self.node = node
        self.support = support
        self.name = name
        self.callback = callback
        self.qos = qos
        self.taken = 0
        """How many requests were handed to the callback."""
        self.given_up = 0
        """How many requests the callback gave up."""
        self.latencies = Latencies()
        """The times from the arrival of requests to their responses."""
        self._clock = node.context.shutdown_signal.clock
        self._server = RequestServer(node, support, name, self._handle, qos, group)
        self._server.entity = self
        self.full_name = self._server.full_name
        self._server.open()
        watch_recorders(self)
        node.own(self)

    def _handle(self, request: Request, message: object) -> Coroutine[Any, Any, None] | None:
        self.taken += 1
        if self.introspection is not None:
            _tell(self.introspection, Step.REQUEST_RECEIVED, request, message)
        try:
            answer = self.callback(message, self.support.response())
            if isinstance(answer, CoroutineType):
                return Answering(answer, request, self.send_response, self.failed, self._count_failure)
            self.send_response(answer, request)
        except Exception as error:
            self._count_failure()
            if self.failed is None:
                raise
            request.cancel(reasons.explain_failure(error))
            self.failed(error)
        return None

    def _count_failure(self) -> None:
        self.given_up += 1

    def send_response(self, response: object, header: Request) -> None:
        """Answer the request that `header` stands for. Every response goes through this method, as in rclpy.

        So a program may replace it by its own function, and answer later. Raises TypeError for another type,
        InvalidHandle once destroyed.
        """
        if self._server.destroyed:
            raise InvalidHandle
        expected = self.support.response
        if response.__class__ is not expected and not isinstance(response, expected):
            raise TypeError(
                f"Service '{self.full_name}': the callback returned {type(response).__name__}; "
                f"return the {expected.__name__} that it was given: write 'return response'"
                f'{at(function_place(self.callback))}'
            )
        introspection = self.introspection  # read first: on the reply the client may switch this off
        header.reply(self.support.encode_response(response))
        took = self._clock.system_now() - header.sample.received_timestamp
        self.latencies.counts[took.bit_length() if took > 0 else 0] += 1
        if introspection is not None:
            _tell(introspection, Step.RESPONSE_SENT, header, response)

    @property
    def event_queue(self) -> EventQueue[Request]:
        """The requests that wait."""
        return self._server.event_queue

    def take(self) -> tuple[Any, Request] | None:
        """Take the oldest waiting request, without the callback, and the header for its response; else None.

        Raises InvalidHandle once destroyed.
        """
        if self._server.destroyed:
            raise InvalidHandle
        taken = self._server.take()
        if taken is not None:
            message, request = taken
            self.taken += 1
            if self.introspection is not None:
                _tell(self.introspection, Step.REQUEST_RECEIVED, request, message)
        return taken

    def statistics(self) -> ServiceStatistics:
        """Return the counts of requests received, and of their outcomes."""
        from goalwire.rules.statistics import ServiceStatistics

        answered = self.latencies.count
        return ServiceStatistics(
            self.full_name,
            answered,
            self.given_up,
            self.taken - answered - self.given_up,
            len(self.event_queue),
            self._server.refused,
            self._server.rejected,
            self.latencies.histogram(),
        )

    @property
    def destroyed(self) -> bool:
        """True once the service is destroyed."""
        return self._server.destroyed

    def destroy(self) -> None:
        """Undeclare the service; waiting requests are cancelled, so that their clients get an error.
        Idempotent.
        """
        self.node.disown(self)
        self.end_introspection()
        self._server.destroy()


def _tell(introspection: ServiceIntrospection, step: Step, request: Request, message: object) -> None:
    introspection.report(step, request.sample.gid, request.sample.sequence, message)
