"""The receiving end of a service: queues requests, decodes them, and rejects those that it cannot decode."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ServiceSupport
from goalwire.errors import RemoteError
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.weak_methods import weakly
from goalwire.fault_reports import log_rejected
from goalwire.rules import reasons
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, Payload, Port, Request

QUEUE_LIMIT = 10_000
"""Requests that may wait at one server. Beyond it the newest is refused, counted and logged, whatever the
user's depth says: ROS 2 drops the oldest silently, and its client waits for ever."""


class RequestServer:
    """Declares a service, with `open`, and calls `handle(request, message)` on the executor, in `group`.

    `decode` makes the message of the payload; the default is the request class's own. If `handle` raises, the
    request is given up, so that its client learns of it, and the error comes out of spin.
    """

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        handle: Callable[[Request, Any], object],
        qos: QoS,
        group: CallbackGroup,
        *,
        decode: Callable[[Payload], Any] | None = None,
    ) -> None:
        self.node = node
        self.full_name = node.resolve(name, is_service=True)
        self.refused = 0
        """How many requests found the queue full."""
        self.rejected = 0
        """How many requests could not be decoded."""
        self.support = support
        self._decode = decode
        self._call = handle
        self.event_queue: EventQueue[Request] = EventQueue(
            node.work_queue, group, self._handle, depth=QUEUE_LIMIT, refuse=weakly(self._refuse)
        )
        self._forget = partial(node.context.deadlock_detector.remove, self.full_name, self.event_queue)
        self.entity: object = self
        """The service or action server that has this request server, for executors that users have written.
        """
        self._endpoint = describe_endpoint(node, EndpointKind.SERVICE, self.full_name, support, qos)
        self._port: Port | None = None
        self.destroyed = False

    def open(self) -> None:
        """Begin to take requests. They may be handled, on another thread, before this method returns."""
        node = self.node
        node.context.deadlock_detector.add(self.full_name, self.event_queue)
        node.remains.add(self._forget)
        try:
            self._port = node.port.service(self._endpoint, self.event_queue.deliver)
        except BaseException:
            self._leave_detector()
            raise

    def _leave_detector(self) -> None:
        self.node.remains.discard(self._forget)
        self._forget()

    def _refuse(self, request: Request) -> None:
        if self.event_queue.closed:
            request.cancel()
        else:
            request.cancel(reasons.explain_refusal(f'{QUEUE_LIMIT} requests wait already'))
            self.refused += 1
            self._log('a request was refused', self.refused, f'{QUEUE_LIMIT} requests wait already')

    def work_off(self) -> None:
        """Handle the waiting requests on the calling thread, without the executor."""
        while (request := self.event_queue.take()) is not None:
            self._handle(request)

    def _handle(self, request: Request) -> object:
        if self.destroyed:  # a request slipped in while the server was being destroyed
            request.cancel()
            return None
        try:
            message = (self._decode or self.support.decode_request)(request.sample.payload)
        except RemoteError as error:
            self._reject(request, error)
            return None
        try:
            return self._call(request, message)
        except BaseException as error:
            request.cancel(reasons.explain_failure(error))
            raise

    def take(self) -> tuple[Any, Request] | None:
        """Take the oldest waiting request, decoded, without the executor; None if there is none."""
        while (request := self.event_queue.take()) is not None:
            try:
                return (self._decode or self.support.decode_request)(request.sample.payload), request
            except RemoteError as error:
                self._reject(request, error)
        return None

    def _reject(self, request: Request, error: RemoteError) -> None:
        self.rejected += 1
        request.cancel(reasons.explain_rejection(error))
        self._log('a request was rejected', self.rejected, error)

    def _log(self, what: str, count: int, reason: object) -> None:
        what = f"Service '{self.full_name}': {what}"
        log_rejected(self.node.logger_name, what, count, reason, is_error=True)

    def destroy(self) -> None:
        """Undeclare the service; waiting requests are cancelled. Idempotent."""
        self.destroyed = True
        port, self._port = self._port, None
        if port is None:
            return
        self._leave_detector()
        port.close()
        while (request := self.event_queue.take()) is not None:
            request.cancel()
        self.event_queue.close()
