"""The requests of an action client, and its three clients on the wire: for goals, cancelling and results.

How a request is sent, answered, ended in time or cancelled is in goalwire.entities.pending_call. An action
adds two things. If a goal is accepted after its client has stopped waiting, it is cancelled. And a request
for a result is sent again as long as somebody waits for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from goalwire.entities.actions.cancel_warnings import watch_answer
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.pending_call import (
    MARGIN_S,
    NO_REASON,
    PENDING_LIMIT,
    REASONS_LIMIT,
    PendingCall,
    RequestClient,
    end_with,
)
from goalwire.entities.recorder_watch import watch_recorders
from goalwire.entities.service_introspection import Introspected, IntrospectedCall
from goalwire.errors import DeadlineError, GoalwireError, TooManyCallsError
from goalwire.execution.future import Future
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.rules import reasons
from goalwire.rules.goals import wire
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.client_goal_handle import ResultFuture
    from goalwire.entities.graph_waiting import ServerWaitQueue
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.execution.event_queue import ResponseTicks
    from goalwire.logging import RcutilsLogger
    from goalwire.rules.goals.client import ClientGoal
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Payload, Sample

LATE_S = 10.0
"""How long, in s, a server may still accept a goal that nobody waits for any more. The goal is cancelled
then.
"""

LATE_LIMIT = 1000
"""How many goals of one client may wait for a late acceptance."""


class ActionSide(Protocol):
    """An action client as its requests see it (ActionClientCore)."""

    node: NodeCore
    name: str
    logger: RcutilsLogger
    destroyed: bool
    arrivals: ResponseTicks
    """Has the executor do one empty turn for each answer that no blocked thread waits for, so that
    `spin_once` returns.
    """

    @property
    def default_timeout(self) -> float | None:
        """How long calls may take, in s; None: as in ROS 2."""

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""

    def server_is_there(self) -> bool:
        """True while there is a server that can be called."""

    def make_wait_queue(self) -> ServerWaitQueue:
        """Return the queue in which requests to this action wait for a server."""

    def on_goal_reply(self, call: GoalCall, sample: Sample) -> None:
        """Take a server's answer to a goal: accepted or refused."""

    def discard_goal(self, goal: ClientGoal[ResultFuture], reason: str) -> None:
        """Drop the record of a goal that no server has accepted."""

    def cancel_quietly(self, goal_id: GoalId) -> None:
        """Ask for cancellation, and ignore the server's answer."""


class ResultSide(Protocol):
    """The results of an action client as seen by the requests for them (GoalResults)."""

    def on_reply(self, call: ResultCall, sample: Sample) -> None:
        """Take the result that has come."""

    def on_lost(self, call: ResultCall, reason: str) -> None:
        """Note that no result will come."""


class ActionRequests(RequestClient, Introspected):
    """One of the three clients of an action client."""

    margin_s = LATE_S + MARGIN_S

    def __init__(self, action: ActionSide, what: str, name: str, support: ServiceSupport, qos: QoS) -> None:
        """`what` names the kind of request in the warning that nobody answers."""
        self.action = action
        self.what = what
        self.support = support
        super().__init__(action.node, describe_endpoint(action.node, EndpointKind.CLIENT, name, support, qos))
        self.arrivals = action.arrivals
        self.late: dict[GoalCall, None] = {}
        """Goals that nobody waits for any more, and which a server may still accept."""
        self._reported: set[str] = set()
        watch_recorders(self)

    def send(self, payload: bytes, call: PendingCall) -> None:
        introspection, port = self.introspection, self._port
        if introspection is not None and port is not None and call.introspected is None:
            request = introspection.decode_request(payload)
            call.introspected = IntrospectedCall(introspection, port.gid, request)
        super().send(payload, call)

    @property
    def destroyed(self) -> bool:
        return self._port is None

    def reaches_server(self) -> bool:
        """True if the wire has a server for this service."""
        return self._port is not None and self._port.reaches_server()

    def server_is_there(self) -> bool:
        return self.action.server_is_there()

    def make_wait_queue(self) -> ServerWaitQueue:
        self.wait_queue = self.action.make_wait_queue()
        return self.wait_queue

    def report_unanswered(self, reason: str) -> None:
        """Log that nobody will answer a request: once for each of the first REASONS_LIMIT reasons."""
        action = self.action
        if action.destroyed or not self.node.context.ok() or action.default_timeout is not None:
            return  # this side has ended the call, or the program gets an error
        if reason in self._reported or len(self._reported) == REASONS_LIMIT:
            return
        self._reported.add(reason)
        action.logger.warning(
            f"Action '{action.name}': no server answered the {self.what} ({reason or NO_REASON}). The "
            'future stays pending, as in ROS 2: call wait_for_server() first, and wait with a timeout'
        )

    def check_room(self) -> None:
        """Raise TooManyCallsError if too many requests wait for answers."""
        if len(self.pending) >= PENDING_LIMIT or len(self.timed) >= PENDING_LIMIT:
            raise TooManyCallsError(
                f"cannot use the action '{self.action.full_name}': {PENDING_LIMIT} requests of this client "
                'wait for answers already; give goals a timeout, or wait for some of them first'
            )

    def what_fails(self) -> str:
        return f"cannot use the action '{self.action.name}'"

    def close(self) -> None:
        for call in (*self.late,):
            call.discard_late()
        self.end_introspection()
        super().close()


class GoalCall(PendingCall):
    """A goal on its way to a server.

    If it is accepted when nobody waits for it any more, it is cancelled, unless it is to be kept.
    """

    awaited_by: ActionRequests
    late: TimerEntry | None = None
    """The alarm that ends the time for a late acceptance, which is cancelled; None while somebody waits."""
    has_reply = False
    """True once a server has answered. If a second server of the name does so too, that is logged."""

    def __init__(
        self,
        client: ActionRequests,
        goal: ClientGoal[ResultFuture],
        decode: Callable[[Any], Any],
        *,
        keep: bool = False,
    ) -> None:
        """`keep`: the goal goes on if it is accepted when nobody waits for it any more."""
        super().__init__(client, decode)
        self.goal = goal
        self._keep = keep

    def on_reply(self, sample: Sample) -> None:
        self.tell_reply(sample)
        if self.late is None:
            self.has_reply = True
            self.take_reply()
            self.awaited_by.action.on_goal_reply(self, sample)  # also logs a second server's answer
        elif wire.is_acceptance(sample.payload):
            self.awaited_by.node.context.sends.soon(TimerEntry(self._cancel_quietly))

    def on_end(self, reason: str) -> None:
        if self.late is not None:
            self.discard_late()
        elif self.call_context is not None:
            super().on_end(reason)
        elif self.end():
            client = self.awaited_by
            client.pending.pop(self.sent_as, None)
            client.action.discard_goal(self.goal, reason)
            client.report_unanswered(reason)

    def fail(self, error: Exception) -> None:
        if not self.end():
            return
        client = self.awaited_by
        if self.was_sent and isinstance(error, DeadlineError) and not self._keep:
            self._await_late_accept(client)
        else:
            self.discard_request()
        client.action.discard_goal(self.goal, '')
        if self.pending():
            end_with(self, error)

    def discard_request(self) -> None:
        if self.has_reply:  # the reply came before the request's number was known
            self.awaited_by.pending.pop(self.sent_as, None)
        else:
            super().discard_request()

    def discard(self) -> None:
        if self.end():
            self.discard_request()
            self.awaited_by.action.discard_goal(self.goal, '')

    def cancel_goal(self) -> None:
        """Stop waiting for a server to accept the goal, and cancel it if one does.

        The future gets no error.
        """
        Future.cancel(self)
        self.fail(DeadlineError(f'{self.awaited_by.what_fails()}: nobody waits for the answer any more'))

    def _await_late_accept(self, client: ActionRequests) -> None:
        """Listen for a late acceptance for a while; for the latest LATE_LIMIT goals only."""
        context = client.node.context
        self.late = TimerEntry(self.discard_late)
        client.late[self] = None
        if len(client.late) > LATE_LIMIT:
            next(iter(client.late)).discard_late()
        context.deadlines.set(self.late, context.shutdown_signal.clock.now() + int(LATE_S * 1e9))

    def discard_late(self) -> None:
        """Stop listening for a late acceptance."""
        client = self.awaited_by
        if self.late is not None:
            client.node.context.deadlines.discard(self.late)
        client.late.pop(self, None)
        self.discard_request()

    def _cancel_quietly(self) -> None:
        self.discard_late()
        self.awaited_by.action.cancel_quietly(self.goal.goal_id)


class CancelCall(PendingCall):
    """A cancel request. It does not wait for a server: the goal to cancel has one."""

    awaited_by: ActionRequests
    waits = False

    def __init__(
        self, client: ActionRequests, decode: Callable[[Payload], object], asked_at: str = ''
    ) -> None:
        """`asked_at` is the program's line that a warning names if the program does not read a refusal."""
        super().__init__(client, decode)
        self._asked_at = asked_at

    @property
    def is_unread(self) -> bool:
        """Whether the answer is there, and nobody has looked at it."""
        return self._raw is not None

    def on_reply(self, sample: Sample) -> None:
        super().on_reply(sample)
        place, self._asked_at = self._asked_at, ''
        if place:
            client = self.awaited_by
            watch_answer(self, client.node, client.action.full_name, place)


class ResultCall(PendingCall):
    """The request for one goal's result, shared by all who wait for it.

    A goal may run longer than a request can wait: Zenoh gives a request up after ten minutes, and holds
    memory for it until then. So the request is sent again. That does no harm, since a server answers each
    request.
    """

    awaited_by: ActionRequests

    def __init__(self, client: ActionRequests, goal: ClientGoal[ResultFuture], results: ResultSide) -> None:
        super().__init__(client, bytes)
        self.goal = goal
        self._results = results

    def on_reply(self, sample: Sample) -> None:
        if self.take_reply():
            self.tell_reply(sample)
            self._results.on_reply(self, sample)

    def on_end(self, reason: str) -> None:
        if self.end_lock.locked():
            return
        client = self.awaited_by
        if reason == reasons.TIMEOUT:
            client.node.context.sends.soon(TimerEntry(self._send_again))
        elif self.end():
            client.pending.pop(self.sent_as, None)
            self._results.on_lost(self, reason)

    def _send_again(self) -> None:
        client = self.awaited_by
        client.pending.pop(self.sent_as, None)
        if self.end_lock.locked():
            return
        try:
            client.send(wire.encode_result_request(self.goal.goal_id), self)
        except GoalwireError:  # the client is closed, or the wire refuses the request
            if self.end():
                self._results.on_lost(self, '')
