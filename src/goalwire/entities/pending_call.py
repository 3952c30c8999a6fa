"""A pending call: one request, and how it is answered, times out, is sent again or is cancelled.

A `RequestClient` is one client of one service on the wire. A `PendingCall` is one request of it, and the
future of its response. A service client is a RequestClient. An action client has three: for goals, for
cancelling and for results. Both APIs use them.

A call without a `CallContext` behaves as in ROS 2: it is sent at once, and its future stays pending if nobody
answers. A call with one first waits for a server and always ends: with its response or with a typed error, at
its deadline, when its server goes, or when the client or the context ends. With a `Retry` policy it is sent
again.

Several threads may end a call: the one that brings the reply, the one on which the wire says that no reply
can come, the deadline's, the caller's, the one that ends the context. The first to take `end_lock` ends it
and completes the future.

Actions add to this in goalwire.entities.actions.client_requests. A subclass whose reply is more than a value
overrides `on_reply` (`take_reply` says whether it is the first reply), `on_end`, `fail` and `discard`, which
begin with `end()`. A subclass that goes on listening for a while overrides `discard_request`. A subclass with
`waits = False` is sent without waiting for a server.
"""

from __future__ import annotations

from _thread import allocate_lock
from typing import TYPE_CHECKING, Any

from goalwire.entities.graph_waiting import ServerWaitQueue
from goalwire.entities.retrying import CallAttempts, Retries, do_nothing
from goalwire.errors import CallError, ClosedError, DeadlineError, InvalidHandle
from goalwire.execution.event_queue import ResponseTicks
from goalwire.execution.future import FINISHED, PENDING, Future
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.rules import reasons
from goalwire.rules.latencies import Latencies

if TYPE_CHECKING:
    from _thread import LockType
    from collections.abc import Callable, Sequence

    from goalwire.entities.call_deadlines import CallContext
    from goalwire.entities.node import NodeCore
    from goalwire.entities.service_introspection import IntrospectedCall
    from goalwire.transport.contract import ClientPort, Endpoint, Sample

PENDING_LIMIT = 10_000
"""How many calls of one client may wait for their answers. ROS 2 has no limit, and its clients leak if nobody
answers."""

MARGIN_S = 1.0
"""How much longer, in s, than the caller the wire waits, so that the caller's deadline comes first."""

REASONS_LIMIT = 10
"""How many different reasons for missing answers one client logs: servers choose their words."""

NO_REASON = 'there is none, or it went away'


def unanswered(what: str, reason: str) -> CallError:
    """Return the error for a server's silence: it went away or, if it said so, gave the request up."""
    return reasons.meaning(reason)(f'no server answered the {what} ({reason or NO_REASON})')


def end_with(future: Future[Any], error: Exception) -> None:
    """Complete a request's future with `error`.

    If the program itself closed the client, no warning follows that nobody looked at the error.
    """
    future.set_exception(error)
    if isinstance(error, ClosedError):
        future.exception()


class PendingCall(Future[Any]):
    """One request, and the future of its response. The response is decoded by the thread that asks for it.

    An attribute that few calls need belongs to the class until a call sets it. Programs set attributes of
    their own on futures, so the names here are unlikely to collide with them.
    """

    __slots__ = ('awaited_by', 'decode', 'end_lock', 'sent_as', 'sent_ns')

    awaited_by: RequestClient
    """The client that has made this call."""
    decode: Callable[[Any], Any]
    end_lock: LockType
    """Taken by the thread that ends the call."""
    sent_as: int
    """The number of the request that was sent last; 0 while none is on its way."""
    sent_ns: int
    """When the request was sent last, in ns since the UNIX epoch, as a reply's `received_timestamp`."""
    call_context: CallContext | None = None
    """The call's deadline, and the facts for its errors; None: the future stays pending if nobody answers."""
    waits = True
    """Whether a call with a context waits for a server. Else it is sent at once."""
    was_sent = False
    """Whether a call with a context was handed to the wire."""
    encoded = b''
    """The request of a call with a context, which is sent later or again."""
    introspected: IntrospectedCall | None = None
    """Publishes the steps of this call; None if nobody asked for that."""
    _alarm: TimerEntry | None = None
    _attempts: CallAttempts | None = None

    def __init__(self, client: RequestClient, decode: Callable[[Any], Any]) -> None:
        """`decode` makes the response from the reply's payload."""
        # hot path: the constructor of Future is written out, which saves one of a service call's 40 calls
        self.completion_state = PENDING
        self._result = self._exception = self._raw = None
        self._wakers = []
        self._callbacks = []
        self._work_queue = client.node.work_queue
        self.awaited_by = client
        self.decode = decode
        self.end_lock = allocate_lock()
        self.sent_as = 0

    # -- sending -------------------------------------------------------------------------------------------

    def start(self, call_context: CallContext, payload: bytes) -> None:
        """Send the request, or wait for a server. If sending raises, nothing is left of the call.

        Raises ShutDownError after the context's end.
        """
        client, context, deadline = self.awaited_by, call_context.context, call_context.deadline
        self.call_context, self.encoded = call_context, payload
        if client.retries is not None:
            self._attempts = CallAttempts(client.retries, call_context, self.out_of_patience, self.resume)
        # Before the look at the signal: the context's end sets the signal, then looks in `timed`
        client.timed[self] = None
        if deadline is None and not client.watches_end:
            client.watch_end()
        if not context.shutdown_signal.alive:  # else the alarm would fail a future that nobody has yet
            self.end()
            raise context.shutdown_signal.end_error(call_context.title)
        try:
            if deadline is not None:
                self._alarm = TimerEntry(self._on_deadline)
                context.deadlines.set(self._alarm, deadline)
            self._send_when_served(client, call_context)
        except BaseException:
            self.end()
            raise

    def resume(self) -> None:
        """Go on if the call is not over, and give the future the error if that fails."""
        context = self.call_context
        if context is None or self.end_lock.locked():
            return
        try:
            self._send_when_served(self.awaited_by, context)
        except Exception as error:
            self.fail(error)

    def _send_when_served(self, client: RequestClient, context: CallContext) -> None:
        queue = client.wait_queue or client.make_wait_queue()
        if queue.has_server():
            context.servers = queue.servers
        elif self.waits:
            queue.add(self)
            if self.end_lock.locked():
                queue.discard(self)  # the call has ended meanwhile
            return
        self.was_sent = True
        if self._attempts is None:
            client.send(self.encoded, self)
        else:
            self._send_attempt(self._attempts, client)

    # -- how it ends ---------------------------------------------------------------------------------------

    def on_reply(self, sample: Sample) -> None:
        """Take the first reply; those of further servers of the same name are ignored, as in ROS 2."""
        # hot path: `take_reply` and `set_raw` are written out, which saves three of a service call's 43 calls
        if not self.end_lock.acquire(False):
            return
        client = self.awaited_by
        client.pending.pop(self.sent_as, None)
        if self.call_context is not None:
            self._discard_timers(is_answered=True)
        if self.introspected is not None:
            self.introspected.report_response(sample)
        took = sample.received_timestamp - self.sent_ns
        client.latencies.counts[took.bit_length() if took > 0 else 0] += 1
        if self.completion_state == PENDING:
            self._raw = sample.payload
            self.completion_state = FINISHED
            if not self._tell():
                client.arrivals.deliver(None)
        client.events += 1
        for wake in client.watchers:
            wake()

    def take_reply(self) -> bool:
        """End the call because a reply has come: True for the first one. It does not complete the future."""
        if not self.end_lock.acquire(False):
            return False
        self.awaited_by.pending.pop(self.sent_as, None)
        if self.call_context is not None:
            self._discard_timers(is_answered=True)
        return True

    def tell_reply(self, sample: Sample) -> None:
        """Publish a reply as an event of the call, if call events are asked for."""
        if self.introspected is not None:
            self.introspected.report_response(sample)

    def complete(self, payload: Any) -> None:
        """Complete the future, unless it was cancelled."""
        if self.completion_state == PENDING and not self.set_raw(payload):
            self.awaited_by.arrivals.deliver(None)

    def on_end(self, reason: str) -> None:
        """End the call, since no reply to its last request can come; `reason` is a server's, or ''."""
        if self.end_lock.locked():
            return
        client, context = self.awaited_by, self.call_context
        if context is not None:
            client.unanswered += 1
            self._on_failed_attempt(self._unanswered(context, reason))
        elif self.end():
            client.pending.pop(self.sent_as, None)
            client.report_unanswered(reason)

    def end(self) -> bool:
        """End the call. True for the first caller only, which has to complete the future."""
        if not self.end_lock.acquire(False):
            return False
        if self.call_context is not None:
            self._discard_timers()
        return True

    def fail(self, error: Exception) -> None:
        """End the call with `error`, unless it has ended."""
        attempts = self._attempts
        if attempts is not None and attempts.take_back() and isinstance(error, CallError):
            attempts.on_failure(error, is_last=True)  # the time of the whole call is up
        if self.end():
            self.discard_request()
            if self.pending():
                end_with(self, error)

    def cancel(self) -> None:
        """Stop waiting for the response."""
        self.discard()
        super().cancel()

    def discard(self) -> None:
        """Stop waiting for the response; the future stays as it is."""
        if self.end():
            self.discard_request()

    def discard_request(self) -> None:
        """Forget the request that was sent last, here and on the wire."""
        self.awaited_by.discard(self)

    def end_with_context(self) -> None:
        """End the call: its context has ended."""
        if self.call_context is not None:
            self.fail(self.call_context.end_error())

    def _discard_timers(self, *, is_answered: bool = False) -> None:
        """Remove the call from the tables of waiting calls: it has ended."""
        client, context = self.awaited_by, self.call_context
        assert context is not None
        client.timed.pop(self, None)
        alarm, attempts = self._alarm, self._attempts
        if alarm is not None:
            context.context.deadlines.discard(alarm)
            alarm.call = do_nothing  # leave no reference cycle to the garbage collector
        queue = client.wait_queue
        if queue is not None and self in queue.waiting:
            queue.discard(self)
        if attempts is not None:
            if is_answered and attempts.take_back():
                attempts.on_answer()
            attempts.discard_alarms()

    # -- the deadline --------------------------------------------------------------------------------------

    def _on_deadline(self) -> None:
        context = self.call_context
        assert context is not None
        if not context.context.ok():
            self.end_with_context()
        elif self._lacks_server():
            self.fail(context.no_server())
        else:
            self.fail(context.error(DeadlineError, 'no answer came in time'))

    def _lacks_server(self) -> bool:
        client = self.awaited_by
        if self.was_sent:
            # The call waits for a server to send its request again
            return client.wait_queue is not None and self in client.wait_queue.waiting
        try:
            return not client.server_is_there()
        except ClosedError:
            return True

    def _unanswered(self, context: CallContext, reason: str) -> Exception:
        if not context.context.ok():
            return context.end_error()
        problem = reason or 'the server went away before it answered'
        return context.error(reasons.meaning(reason), problem)

    # -- sending again -------------------------------------------------------------------------------------

    def _send_attempt(self, attempts: CallAttempts, client: RequestClient) -> None:
        attempts.begin()
        client.send(self.encoded, self)
        early = attempts.on_send()
        if early is not None:
            self._on_failed_attempt(early)
        if self.end_lock.locked():
            attempts.discard_alarms()  # the call has ended meanwhile

    def out_of_patience(self) -> None:
        """Fail the present attempt: its time is over."""
        context, attempts = self.call_context, self._attempts
        assert context is not None
        assert attempts is not None
        problem = f'no answer came to an attempt within {attempts.retries.policy.timeout} s'
        self._on_failed_attempt(context.error(DeadlineError, problem))

    def _on_failed_attempt(self, error: Exception) -> None:
        """The last attempt has failed: send the request again if the policy says so."""
        attempts, context = self._attempts, self.call_context
        if attempts is None or context is None:
            self.fail(error)
            return
        if attempts.keep_if_early(error) or self.end_lock.locked() or not attempts.take_back():
            return
        context.context.deadlines.discard(attempts.patience)
        self.discard_request()
        delay = attempts.on_failure(error) if isinstance(error, CallError) else None
        if delay is None:
            self.fail(error)
            return
        context.context.sends.set(attempts.again, context.now() + delay)
        if self.end_lock.locked():
            attempts.discard_alarms()


class RequestClient:
    """One client of one service on the wire, and its calls that have not ended."""

    margin_s = MARGIN_S
    """How much longer than the call the wire has to hold a request, in s."""

    def __init__(self, node: NodeCore, endpoint: Endpoint) -> None:
        self.node = node
        self.full_name = endpoint.name
        self.pending: dict[int, PendingCall] = {}
        """The calls that wait for a reply, by the numbers of their requests."""
        self.timed: dict[PendingCall, None] = {}
        """The calls with a call context that have not ended: on their way, or waiting for a server."""
        self.watches_end = False
        """True while the context's end ends the calls in `timed`; calls without a deadline need that."""
        self.events = 0
        """How many responses have come; see waitable.Waited."""
        self.watchers: Sequence[Callable[[], None]] = ()
        self.sent = 0
        """How many requests were handed to the wire."""
        self.unanswered = 0
        """How many requests no server answered: there was none, it went away, or it gave them up."""
        self.latencies = Latencies()
        """The times from requests to their responses."""
        self.arrivals = ResponseTicks(node.work_queue, self)
        self.wait_queue: ServerWaitQueue | None = None
        self.retries: Retries | None = None
        self._clock = node.context.shutdown_signal.clock
        self._port: ClientPort | None = node.port.client(endpoint)

    def start(self, call: PendingCall, payload: bytes, call_context: CallContext | None = None) -> None:
        """Send a request.

        Raises InvalidHandle once closed, ShutDownError after the context's end, TransportError if the wire
        refuses it. With a context or retries it may be sent later, and then the future gets these errors.
        """
        if call_context is None:
            self.send(payload, call)
        else:
            call.start(call_context, payload)

    def send(self, payload: bytes, call: PendingCall) -> None:
        """Hand a request to the wire; its reply, and its end, go to `call`. Raises as `start` does."""
        port = self._port
        if port is None:
            raise InvalidHandle
        context = call.call_context
        left = None if context is None or context.deadline is None else context.left_ns(self.margin_s)
        call.sent_ns = self._clock.system_now()
        try:
            sequence = port.request(payload, call.on_reply, call.on_end, left)
        except ClosedError:
            if self._port is None:
                raise InvalidHandle from None
            raise self.node.context.shutdown_signal.end_error(self.what_fails()) from None
        self.sent += 1
        call.sent_as = sequence
        if call.introspected is not None:
            call.introspected.report_request(sequence)
        self.pending[sequence] = call
        if call.end_lock.locked():  # the call has ended before its request's number was known
            call.discard_request()

    def discard(self, call: PendingCall) -> None:
        """Drop the last request of `call`: ignore its answer, and have the transport cancel the request."""
        sequence, call.sent_as = call.sent_as, 0
        port = self._port
        if self.pending.pop(sequence, None) is not None and port is not None:
            port.cancel(sequence)

    # -- what a subclass says ------------------------------------------------------------------------------

    def server_is_there(self) -> bool:
        """True while there is a server that can be called. Raises ClosedError once the client has ended."""
        raise NotImplementedError

    def make_wait_queue(self) -> ServerWaitQueue:
        """Make `wait_queue`, in which calls wait for a server; clients of one action share theirs."""
        raise NotImplementedError

    def report_unanswered(self, reason: str) -> None:
        """Report an unanswered call without a call context: its future stays pending, as in ROS 2."""
        raise NotImplementedError

    def what_fails(self) -> str:
        """Return the text of the error that a call raises after the end of the context."""
        return f"cannot call '{self.full_name}'"

    # -- its end -------------------------------------------------------------------------------------------

    def watch_end(self) -> None:
        """Have calls without a deadline end with the context. One watch serves them all."""
        self.watches_end = True
        self.node.context.deadlines.tell_end(self)

    def end(self) -> None:
        """End all calls: the context has ended."""
        for call in list(self.timed):
            call.end_with_context()

    def close(self) -> None:
        """Undeclare. Calls with a context end with InvalidHandle, others stay pending. Idempotent."""
        port, self._port = self._port, None
        if port is None:
            return
        for call in list(self.timed):
            call.fail(InvalidHandle())
        for call in list(self.pending.values()):
            call.discard()
        if self.retries is not None:
            self.retries.close()
        self.arrivals.close()
        port.close()
