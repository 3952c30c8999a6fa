"""A service client: sends requests, completes their futures on the thread that brings the reply."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.graph_waiting import tell_near_misses, wait_for_graph
from goalwire.entities.node import NodeCore
from goalwire.entities.service_introspection import Introspected, IntrospectedCall
from goalwire.entities.timed_calls import TimedCalls
from goalwire.entities.type_support import ServiceSupport
from goalwire.errors import (
    CallError,
    ClosedError,
    DeadlineError,
    InvalidHandle,
    NoServerError,
    ShutDownError,
    TooManyCallsError,
)
from goalwire.execution.blocking import abandon, block_on
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import ResponseTicks
from goalwire.execution.future import FINISHED, PENDING, Future
from goalwire.execution.monotonic import deadline_after
from goalwire.logging import get_logger
from goalwire.rules import reasons
from goalwire.rules.latencies import Latencies
from goalwire.rules.qos import QoS
from goalwire.transport.contract import ClientPort, EndpointKind, Sample

if TYPE_CHECKING:
    from goalwire.entities.request_timeout import RequestTimeout
    from goalwire.entities.retrying import Retries
    from goalwire.entities.server_wait_queue import ServerWaitQueue
    from goalwire.rules.retries import Retry
    from goalwire.rules.statistics import ClientStatistics

PENDING_LIMIT = 10_000
"""Calls of one client that may wait for their answers. ROS 2 has no limit, and its clients leak where nobody
answers."""

MARGIN_S = 1.0
"""How much longer than its caller the wire waits: the caller's deadline says what happened."""

REASONS_LIMIT = 10
"""Different reasons for missing answers that one client logs: servers choose their words."""

NO_REASON = 'there is none, or it went away'


def unanswered(what: str, reason: str) -> CallError:
    """Return what a server's silence means: it went away or, where it said so, gave the request up."""
    return reasons.meaning(reason)(f'no server answered the {what} ({reason or NO_REASON})')


def end_with(future: Future[Any], error: Exception) -> None:
    """Complete a request's future with `error`.

    Nobody is reminded of one that was not looked at, where the program itself has closed what it waited for.
    """
    future.set_exception(error)
    if isinstance(error, ClosedError):
        future.exception()


class ResponseFuture(Future[Any]):
    """The response to one request; decoded by who asks for it, not by the transport's thread.

    `ClientCore.begin` fills it in: an __init__ of its own would cost every call 0.6 us. What few calls need
    is an attribute of the class until then. Programs keep things of their own on futures: so the names are
    such as nobody else would take.
    """

    __slots__ = ('awaited_by', 'decode', 'sent_as', 'sent_ns')

    awaited_by: ClientCore | None
    """Who counts on it; None once it waits for nothing any more: answered, given up, or unanswered."""
    decode: Callable[[Any], Any]
    sent_as: int
    """Of what was sent last; 0 while nothing is on its way."""
    sent_ns: int
    """When, in ns since the UNIX epoch, as a reply's `received_timestamp`."""
    guard: RequestTimeout | None = None
    """What makes it end in time; None where it may stay pending, as in ROS 2."""
    encoded = b''
    """What a guard sends, in time."""
    introspected: IntrospectedCall | None = None
    """Where the steps of this call are told; None where nobody wants to know."""
    forgotten = False
    """True once nobody waits for it any more."""
    unanswered = False
    """True once the transport has said that no reply can come any more."""
    why_ended = ''
    """Why, in a server's words."""

    def on_reply(self, sample: Sample) -> None:
        """Take the first reply; those of further servers of the same name are ignored, as in ROS 2."""
        guard = self.guard
        if guard is not None and not guard.answered():
            return
        client, self.awaited_by = self.awaited_by, None
        if client is None:
            return
        client.pending.pop(sample.sequence, None)
        if guard is not None:
            client.guarded.pop(self, None)
        if self.introspected is not None:
            self.introspected.received(sample)
        took = sample.received_timestamp - self.sent_ns
        client.latencies.counts[took.bit_length() if took > 0 else 0] += 1
        if self._state == PENDING:  # as set_raw, which would be one call more
            self._raw = sample.payload
            self._state = FINISHED
            if not self._tell():
                client.arrivals.deliver(None)
        client.events += 1
        for wake in client.watchers:
            wake()

    def on_end(self, reason: str) -> None:
        """No reply can come any more."""
        client = self.awaited_by
        if client is None:
            return
        if self.guard is not None:
            client.unanswered += 1
            self.guard.unanswered(reason)
            return
        self.unanswered, self.why_ended = True, reason
        self.awaited_by = None
        if client.pending.pop(self.sent_as, None) is not None:
            client.report_unanswered(reason)

    def cancel(self) -> None:
        """Give the response up."""
        self.forget()
        super().cancel()

    def forget(self) -> None:
        """Wait for the response no longer."""
        if self.guard is not None:
            self.guard.end()
        if self.awaited_by is not None:
            self.forgotten = True  # first: who is sending looks at both
        client, self.awaited_by = self.awaited_by, None
        if client is not None:
            client.guarded.pop(self, None)
            client.withdraw(self)

    # -- what its guard asks for

    def send(self) -> None:
        """Hand the request to the wire, perhaps once more; raises as ClientCore.call_async does."""
        client = self.awaited_by
        if client is not None:
            client.send(self.encoded, self)

    def withdraw(self) -> None:
        """Wait no longer for the answer to what was sent last."""
        client = self.awaited_by
        if client is not None:
            client.withdraw(self)

    def fail(self, error: Exception) -> None:
        """Complete it with `error`."""
        self.forget()
        if self.pending():
            end_with(self, error)


class ClientCore(TimedCalls, Introspected):
    """Calls one service. `pending` maps the sequence numbers of unanswered requests to their futures."""

    counts_up = True

    def __init__(
        self, node: NodeCore, support: ServiceSupport, name: str, qos: QoS, group: CallbackGroup | None = None
    ) -> None:
        self.node = node
        self.support = support
        self.name = name
        self.qos = qos
        self.callback_group = group
        self.pending: dict[int, ResponseFuture] = {}
        self.guarded: dict[ResponseFuture, None] = {}
        """The calls with a guard that are not over: on their way, or waiting for a server."""
        self.events = 0
        """How many responses have come; see wait_set.Waited."""
        self.watchers: Sequence[Callable[[], None]] = ()
        self.sent = 0
        """How many requests were handed to the wire."""
        self.latencies = Latencies()
        """From requests to their responses."""
        self._clock = node.context.shutdown_signal.clock
        self.unanswered = 0
        """How many requests no server answered: there was none, it went away, or it gave them up."""
        self._reported: set[str] = set()
        self._told = ''
        """What was said last of names and types that are near."""
        self.arrivals = ResponseTicks(node.work_queue, self)
        self.full_name = node.resolve(name, is_service=True)
        self._request_class = support.request
        self._encode = support.encode_request
        endpoint = describe_endpoint(node, EndpointKind.CLIENT, self.full_name, support, qos)
        self._port: ClientPort | None = node.port.client(endpoint)
        self._line: ServerWaitQueue | None = None
        self._retries: Retries | None = None
        node.own(self)

    def call_async(self, request: Any) -> Future[Any]:
        """Send a request and return the future of its response.

        Raises TypeError for another type, EncodeError where a field cannot go on the wire, InvalidHandle
        once destroyed, ShutDownError after the context's end, TooManyCallsError. As in ROS 2 the future stays
        pending where nobody answers, unless there is a `default_timeout`.
        """
        return self.begin(request, self.default_timeout)

    def begin(self, request: Any, timeout: float | None) -> ResponseFuture:
        """Send a request with a time for all of it: waiting for a server, sending, the answer.

        The future ends with the response, NoServerError or DeadlineError after `timeout` s, another CallError
        as soon as it is known, InvalidHandle or ShutDownError; inf has no end, and None means what ROS 2
        means. Raises as `call_async` does, and ValueError for a time that is not a number.
        """
        if request.__class__ is not self._request_class and not isinstance(request, self._request_class):
            raise TypeError(f'Expected {self._request_class}, got {type(request)}')
        port = self._port
        if port is None:
            raise InvalidHandle
        if len(self.pending) >= PENDING_LIMIT or len(self.guarded) >= PENDING_LIMIT:
            raise TooManyCallsError(
                f"cannot call '{self.full_name}': {PENDING_LIMIT} calls of this client wait for answers "
                'already; give calls a timeout, or wait for some of them first'
            )
        future = ResponseFuture(self.node.work_queue)
        future.awaited_by, future.decode, future.sent_as = self, self.support.decode_response, 0
        introspection = self.introspection
        if introspection is not None:
            future.introspected = IntrospectedCall(introspection, port.gid, request)
        payload = self._encode(request)
        if timeout is None and self._retries is None:
            self.send(payload, future)
        else:
            guard = (self._line or self._new_line()).guard(future, timeout, self._retries)
            self.guarded[future] = None
            future.guard, future.encoded = guard, payload
            try:
                guard.begin()
            except BaseException:
                self.guarded.pop(future, None)
                raise
        return future

    def _new_line(self) -> ServerWaitQueue:
        from goalwire.entities.server_wait_queue import ServerWaitQueue

        self._line = ServerWaitQueue(self.node.context, self.server_is_there, 'service', self.full_name)
        return self._line

    @property
    def retry(self) -> Retry | None:
        """How requests are sent again; None: they are not."""
        return None if self._retries is None else self._retries.policy

    @retry.setter
    def retry(self, policy: Retry | None) -> None:
        from goalwire.entities.retrying import Retries

        before, self._retries = self._retries, None if policy is None else Retries(policy, self.node)
        if before is not None:
            before.close()

    def send(self, payload: bytes, future: ResponseFuture) -> None:
        """Hand a request to the wire; its reply, and its end, go to `future`. Raises as call_async does."""
        port = self._port
        if port is None:
            raise InvalidHandle
        guard = future.guard
        left = (
            None
            if guard is None or guard.call_context.deadline is None
            else guard.call_context.left_ns(MARGIN_S)
        )
        future.sent_ns = self._clock.system_now()
        try:
            sequence = port.request(payload, future.on_reply, future.on_end, left)
        except ClosedError:
            if self._port is None:
                raise InvalidHandle from None
            raise ShutDownError(f"cannot call '{self.full_name}'") from None
        self.sent += 1
        future.sent_as = sequence
        if future.introspected is not None:
            future.introspected.sent(sequence)
        self.pending[sequence] = future
        if future.awaited_by is None and self.pending.pop(sequence, None) is not None:
            if future.unanswered:  # before this number was known
                self.report_unanswered(future.why_ended)
            elif future.forgotten:
                port.cancel(sequence)

    def withdraw(self, future: ResponseFuture) -> None:
        """Hold nothing for what `future` has sent last."""
        sequence, future.sent_as = future.sent_as, 0
        port = self._port
        if self.pending.pop(sequence, None) is not None and port is not None:
            port.cancel(sequence)

    def call(self, request: Any, timeout_sec: float | None = None) -> Any:
        """Send a request and wait for its response.

        Raises DeadlineError or NoServerError, both TimeoutErrors, after `timeout_sec`, as newer rclpy does.
        Works inside callbacks: the thread that brings the reply wakes this one. Raises as call_async does,
        and at once where the server's callback would need the very thread or group that waits here. Without
        `timeout_sec` the `default_timeout` counts, if there is one, and a call that ends badly raises. So
        does one that waits when the context ends: ShutDownError.
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
            abandon(future)
            raise
        if not settled:
            future.forget()
            if future.pending() and not shutdown_signal.alive:
                raise ShutDownError(f"cannot call '{self.full_name}'")
            if future.pending() and timeout_sec is not None:
                raise self._late(timeout_sec)
        try:
            return future.result()
        finally:
            del future  # its exception's traceback holds this frame

    def _late(self, timeout_sec: float) -> CallError:
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
        """Block until there is a server (True) or the time is over (False); None waits without limit.

        Raises as server_is_there does.
        """
        if wait_for_graph(self.node.context, self.server_is_there, timeout_sec):
            return True
        self._told = tell_near_misses(self.node, 'service', self.full_name, self._told)
        return False

    def report_unanswered(self, reason: str) -> None:
        """Count a request that nobody will answer, and say so once for each of the first reasons.

        Not at the end of the context: it is this side that goes then.
        """
        self.unanswered += 1
        if not self.node.context.ok() or reason in self._reported or len(self._reported) == REASONS_LIMIT:
            return
        self._reported.add(reason)
        get_logger(self.node.logger_name).warning(
            f"Service '{self.full_name}': no server answered ({reason or NO_REASON}). The future stays "
            'pending, as in ROS 2: call wait_for_service() first, and give calls a timeout'
        )

    def statistics(self) -> ClientStatistics:
        """Count what was sent, and what came of it."""
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
        """True once destroyed."""
        return self._port is None

    def destroy(self) -> None:
        """Undeclare; pending futures stay pending, as in ROS 2, but for those with a time. Idempotent."""
        port, self._port = self._port, None
        if port is None:
            return
        self.node.disown(self)
        self.end_introspection()
        for future in list(self.guarded):
            future.fail(InvalidHandle())
        for future in list(self.pending.values()):
            future.forget()
        if self._retries is not None:
            self._retries.close()
        self.arrivals.close()
        port.close()
