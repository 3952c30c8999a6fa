"""A service client: sends requests, waits for responses and for servers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.call_deadlines import CallContext, TimedCalls
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.graph_waiting import (
    ServerWait,
    ServerWaitQueue,
    await_graph,
)
from goalwire.entities.message_type_errors import explain_wrong_message
from goalwire.entities.node import NodeCore
from goalwire.entities.pending_call import (
    NO_REASON,
    PENDING_LIMIT,
    REASONS_LIMIT,
    PendingCall,
    RequestClient,
)
from goalwire.entities.recorder_watch import watch_recorders
from goalwire.entities.retrying import Retries
from goalwire.entities.service_introspection import Introspected, IntrospectedCall
from goalwire.entities.type_support import ServiceSupport
from goalwire.errors import (
    CallError,
    DeadlineError,
    DestroyedError,
    InvalidHandle,
    NoServerError,
    ShutDownError,
    TooManyCallsError,
)
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.future import Future, block_on, cancel_quietly
from goalwire.execution.time.steady_clock import deadline_after
from goalwire.logging import get_logger
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.rules.retries import Retry
    from goalwire.rules.statistics import ClientStatistics


class ClientCore(RequestClient, TimedCalls, Introspected):
    """Calls one service, for both APIs."""

    counts_up = True

    def __init__(
        self, node: NodeCore, support: ServiceSupport, name: str, qos: QoS, group: CallbackGroup | None = None
    ) -> None:
        self.support = support
        self.name = name
        self.qos = qos
        self.callback_group = group
        self._reported: set[str] = set()
        self._has_called = False
        self._is_end_told = False
        """Whether it was logged that a call came after the end of the context."""
        self._request_class = support.request
        self._encode = support.encode_request
        full_name = node.resolve(name, is_service=True)
        super().__init__(node, describe_endpoint(node, EndpointKind.CLIENT, full_name, support, qos))
        self._server_wait = ServerWait(node, 'service', full_name, self.server_is_there)
        watch_recorders(self)
        node.own(self)

    def call_async(self, request: Any) -> Future[Any]:
        """Send a request and return the future of its response.

        Raises TypeError for a request of another type, EncodeError if a field cannot go on the wire,
        InvalidHandle once destroyed, TooManyCallsError. As in ROS 2 the future stays pending if nobody
        answers, and after the context's end, which is logged once: destructors often call a service then.
        With a `default_timeout` the future ends with an error, and after the context's end ShutDownError is
        raised.
        """
        if not self._has_called:
            self._has_called = True
            self.node.context.unspun.add_call(self)
        try:
            return self.begin(request, self.default_timeout)
        except ShutDownError as error:
            if self.default_timeout is not None:
                raise
            if not self._is_end_told:
                self._is_end_told = True
                get_logger(self.node.logger_name).warning(f'{error}. The future stays pending, as in ROS 2')
            return Future()

    def begin(self, request: Any, timeout: float | None) -> PendingCall:
        """Send a request. `timeout` limits the whole call: waiting for a server, sending, the answer.

        The future ends with the response, NoServerError or DeadlineError after `timeout` s, another CallError
        as soon as it is known, InvalidHandle or ShutDownError; inf is no limit; with None the future behaves
        as in ROS 2. Raises as `call_async` does, and ValueError for a timeout that is not a number.
        """
        if request.__class__ is not self._request_class and not isinstance(request, self._request_class):
            raise TypeError(explain_wrong_message(self._request_class, request))
        port = self._port
        if port is None:
            raise InvalidHandle
        if len(self.pending) >= PENDING_LIMIT or len(self.timed) >= PENDING_LIMIT:
            raise TooManyCallsError(
                f"cannot call '{self.full_name}': {PENDING_LIMIT} calls of this client wait for answers "
                'already; give calls a timeout, or wait for some of them first'
            )
        call = PendingCall(self, self.support.decode_response)
        introspection = self.introspection
        if introspection is not None:
            call.introspected = IntrospectedCall(introspection, port.gid, request)
        if timeout is None and self.retries is None:
            self.send(self._encode(request), call)
        else:
            context = CallContext(self.node.context, 'service', self.full_name, timeout)
            call.start(context, self._encode(request))
        return call

    def make_wait_queue(self) -> ServerWaitQueue:
        self.wait_queue = queue = ServerWaitQueue(self.node.context, self.server_is_there, self.full_name)
        return queue

    @property
    def retry(self) -> Retry | None:
        """The policy for sending requests again; None: each is sent once."""
        return None if self.retries is None else self.retries.policy

    @retry.setter
    def retry(self, policy: Retry | None) -> None:
        before, self.retries = self.retries, None if policy is None else Retries(policy, self.node)
        if before is not None:
            before.close()

    def call(self, request: Any, timeout_sec: float | None = None) -> Any:
        """Send a request and wait for its response.

        Raises DeadlineError or NoServerError, both TimeoutErrors, after `timeout_sec`, as newer rclpy does.
        Works inside callbacks: the thread that brings the reply wakes this one. Raises as call_async does,
        and WouldDeadlockError, at once, if the server's callback needs the thread or group that waits here.
        Without `timeout_sec` the `default_timeout` is used, if there is one; then a call that fails raises
        its error. Raises ShutDownError if the context ends meanwhile.
        """
        context = self.node.context
        if self.full_name in context.deadlock_detector.event_queues:
            context.deadlock_detector.check(context.graph, self.full_name)
        future = self.begin(request, self.default_timeout if timeout_sec is None else None)
        shutdown_signal = context.shutdown_signal
        deadline = None if timeout_sec is None else deadline_after(shutdown_signal.clock, timeout_sec)
        try:
            settled = block_on(future, deadline, shutdown_signal)
        except BaseException:
            cancel_quietly(future)
            raise
        if not settled:
            future.discard()
            if future.pending() and not shutdown_signal.alive:
                raise context.shutdown_signal.end_error(self.what_fails())
            if future.pending() and timeout_sec is not None:
                raise self._late_error(timeout_sec)
        try:
            return future.result()
        finally:
            del future  # breaks a reference cycle: the exception's traceback holds this frame

    def _late_error(self, timeout_sec: float) -> CallError:
        served = self._port is not None and self.server_is_there()
        what = 'no response came' if served else 'no server came'
        text = f"service '{self.full_name}': {what} within {timeout_sec:g} s"
        if not served:
            from goalwire.graph.near_misses import near_misses

            hint = near_misses(self.node.graph, self.full_name, is_action=False)
            text += f'; {hint}' if hint else ''
        return (DeadlineError if served else NoServerError)(text, name=self.full_name, waited=timeout_sec)

    def server_is_there(self) -> bool:
        """True while there is a server of this name and type that can be called.

        Raises InvalidHandle once destroyed, ShutDownError after the context's end.
        """
        if self._port is None:
            raise InvalidHandle
        self.node.check_open()
        found = self.node.graph.has_service(self.full_name, self.support.type_name)
        return found and self._port.reaches_server()

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Block until there is a server (True) or `timeout_sec` has passed (False); None waits without limit.

        Raises as server_is_there does.
        """
        return self._server_wait.wait(timeout_sec)

    def report_unanswered(self, reason: str) -> None:
        """Count a request that nobody will answer, and log that, once for each of the first reasons. At the
        context's end nothing is logged: then this side has gone, not the server.
        """
        self.unanswered += 1
        if not self.node.context.ok() or reason in self._reported or len(self._reported) == REASONS_LIMIT:
            return
        self._reported.add(reason)
        get_logger(self.node.logger_name).warning(
            f"Service '{self.full_name}': the server gave no answer ({reason}), so the future stays pending: "
            'mend the server, and give calls a timeout'
            if reason
            else f"Service '{self.full_name}': no server answered ({NO_REASON}). The future stays pending, "
            'as in ROS 2: call wait_for_service() first, and give calls a timeout'
        )

    def statistics(self) -> ClientStatistics:
        """Return the counts of requests sent, and of their outcomes."""
        from goalwire.rules.statistics import ClientStatistics

        return ClientStatistics(
            self.full_name,
            self.sent,
            self.events,
            self.unanswered,
            len(self.pending),
            self.latencies.histogram(),
        )

    @property
    def destroyed(self) -> bool:
        """True once this client is destroyed."""
        return self._port is None

    def destroy(self) -> None:
        """Undeclare the client. Pending futures stay pending, as in ROS 2; those with a timeout fail.
        Idempotent.
        """
        if self._port is None:
            return
        self.node.disown(self)
        self.end_introspection()
        self.close()


class AwaitedCalls:
    """The calls of one client that coroutines wait for, under any asyncio loop. Only the loop's thread may
    use them.
    """

    def __init__(self, client: ClientCore) -> None:
        self._client = client
        self._waiting: set[PendingCall] = set()

    async def call(self, request: Any) -> Any:
        """Send a request and wait for its response, for ever if nobody answers.

        Raises CancelledError if `cancel` is called meanwhile, DestroyedError for a destroyed client,
        ShutDownError at shutdown; TypeError and EncodeError for a request of a wrong type, or one that cannot
        be encoded.
        """
        # imported here: asyncio is slow to import
        from asyncio import CancelledError

        from goalwire.execution.asyncio.waiting import settle

        client = self._client
        if client.destroyed:
            raise DestroyedError(f"cannot call '{client.full_name}': the client was destroyed")
        future = client.begin(request, client.default_timeout)
        self._waiting.add(future)
        try:
            await settle(future, client.node.context.shutdown_signal)
        finally:
            self._waiting.discard(future)
            if not future.done():
                future.discard()
        if future.cancelled():
            raise CancelledError(f"the client of '{client.full_name}' was destroyed")
        if future.pending():
            raise client.node.context.shutdown_signal.end_error(f"no response of '{client.full_name}' came")
        try:
            return future.result()
        finally:
            del future  # breaks a reference cycle: the exception's traceback holds this frame

    async def until_served(self) -> None:
        """Wait until there is a server. Raises InvalidHandle if the client is destroyed, ShutDownError."""
        client = self._client
        if not await await_graph(client.node.context, client.server_is_there):
            raise client.node.context.shutdown_signal.end_error(f"no server of '{client.full_name}' came")

    def cancel(self) -> None:
        """Cancel the waiting calls, even if a server may still answer them."""
        for future in list(self._waiting):
            future.cancel()
