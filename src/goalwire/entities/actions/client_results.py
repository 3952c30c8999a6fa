"""The results of goals, each with one request for all its waiters, and the reasons behind failures."""

from __future__ import annotations

from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.entities.actions.client_goal_handle import GoalFeedback, ResultFuture
from goalwire.entities.actions.client_requests import ActionRequests, ResultCall
from goalwire.entities.call_deadlines import CallContext
from goalwire.entities.pending_call import PendingCall, end_with, unanswered
from goalwire.errors import CallError, InvalidHandle, peer_text
from goalwire.rules.goals import wire
from goalwire.rules.latencies import Latencies

if TYPE_CHECKING:
    from collections.abc import Callable
    from threading import Lock

    from goalwire.entities.actions.client_streams import ClientStreams
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.execution.event_queue import ResponseTicks
    from goalwire.execution.future import Future
    from goalwire.rules.goals.client import GoalClient
    from goalwire.rules.goals.ids import GoalId
    from goalwire.transport.contract import Payload, Sample


class ResultClient(Protocol):
    """An action client as its results see it (ActionClientCore)."""

    node: NodeCore
    support: ActionSupport
    goals: GoalClient[ResultFuture, Payload]
    lock: Lock
    streams: ClientStreams
    arrivals: ResponseTicks
    destroyed: bool

    @property
    def default_timeout(self) -> float | None:
        """How long calls may take, in s; None: as in ROS 2."""

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""

    @property
    def goal_service(self) -> str:
        """The fully-qualified name of the service that takes goals."""

    def dispatch(self, event: Callable[..., Any], *args: Any) -> None:
        """Pass an event to the reactor and perform its effects."""

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """Log why a goal was aborted."""


class GoalResults:
    """Asks for the results of one client's goals, and gives each result to the futures that wait for it."""

    def __init__(self, client: ResultClient, requests: ActionRequests) -> None:
        self._client = client
        self._requests = requests
        self.latencies = Latencies()
        """The times from the sending of goals to their results."""

    def ask(self, goal_id: GoalId, call_context: CallContext | None) -> ResultFuture:
        """Return a future for a goal's result: it gives the action's GetResult response."""
        client = self._client
        if call_context is None and client.default_timeout is not None:
            # A goal may run for ever, so its result has no deadline. But if calls have one, its errors are
            # typed.
            call_context = CallContext(client.node.context, 'action', client.full_name, inf)
            call_context.see_servers(client.goal_service)
        goal = client.goals.find(goal_id)
        feedback = None if goal is None else goal.feedback
        decode = client.support.get_result.decode_response
        future = ResultFuture(self, client.node.work_queue, goal_id, decode, call_context, feedback)
        client.dispatch(client.goals.on_result_request, goal_id, future)
        return future

    def ask_once(self, goal_id: GoalId, call_context: CallContext) -> Future[Any]:
        """Send one request for a goal's result, in addition to the shared request of the futures that wait
        for it. Probes of a goal need this.

        The future gives the action's GetResult response and the text that follows it on the wire ('' if there
        is none). Raises InvalidHandle if the client is destroyed.
        """
        if self._client.destroyed:
            raise InvalidHandle
        decode = self._client.support.get_result.decode_response

        def read(raw: Payload) -> tuple[Any, str]:
            payload, text = wire.split_reason(raw)
            return decode(payload), text

        call = PendingCall(self._requests, read)
        self._requests.start(call, wire.encode_result_request(goal_id), call_context)
        return call

    def request(self, goal_id: GoalId) -> None:
        """Send the request for a result that somebody waits for."""
        client = self._client
        with client.lock:
            goal = client.goals.active.get(goal_id)
            if goal is None or goal.request is not None or not goal.waiters:
                return  # no waiter is left, or another thread has asked again meanwhile
            goal.request = call = ResultCall(self._requests, goal, self)
        try:
            self._requests.start(call, wire.encode_result_request(goal_id))
        except BaseException:  # nothing was sent: the next request tries again
            call.end()
            client.dispatch(client.goals.on_result_failed, goal_id, unanswered('result', ''))
            raise

    def cancel(self, future: ResultFuture) -> None:
        """Leave this future pending for good.

        If no other future waits for the goal's result, the request for it is cancelled.
        """
        with self._client.lock:
            request = self._client.goals.on_result_cancelled(future.goal_id, future)
        if request is not None:
            request.discard()

    def on_reply(self, call: ResultCall, sample: Sample) -> None:
        """Take the result. Its waiters get it after the feedback that came before it."""
        client, goal = self._client, call.goal
        payload, reason = wire.split_reason(sample.payload)
        status = wire.status_of(payload)
        if reason and status.is_terminal and not goal.reason:
            goal.reason = peer_text(reason)
            client.note_failure(goal.goal_id, goal.reason)
        if goal.sent_at:
            self.latencies.add(sample.received_timestamp - goal.sent_at)
        if goal.feedback is not None:
            client.streams.catch_up()  # the wire may still hold earlier feedback
        if isinstance(goal.feedback, GoalFeedback):
            goal.feedback.end(partial(client.dispatch, client.goals.on_result, goal.goal_id, status, payload))
        else:
            client.dispatch(client.goals.on_result, goal.goal_id, status, payload)

    def on_lost(self, call: ResultCall, reason: str) -> None:
        """Fail the waiting futures: no result will come."""
        client = self._client
        client.dispatch(client.goals.on_result_failed, call.goal.goal_id, unanswered('result', reason))
        call.awaited_by.report_unanswered(reason)

    def deliver(self, future: Future[Any], payload: Payload) -> None:
        """Give the result to one waiter."""
        if future.pending() and not future.set_raw(payload):  # a future that is not pending was cancelled
            self._client.arrivals.deliver(None)

    def fail(self, future: ResultFuture, error: Exception) -> None:
        """Fail one waiting future if it has a call context; else it stays pending, as in ROS 2."""
        call_context = future.call_context
        if call_context is None or not future.pending():
            return
        if self._client.destroyed:
            end_with(future, InvalidHandle())
        elif not self._client.node.context.ok():
            end_with(future, call_context.end_error())
        else:
            end_with(future, call_context.retell(error) if isinstance(error, CallError) else error)
