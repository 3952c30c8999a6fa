"""An action client: sends goals and completes the futures of what the server answers.

The rules are in goalwire.protocol.goals.client. Replies complete futures on the thread that brings them, so
that no executor is needed to wait; feedback and statuses go through the executor, in the client's group.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from math import inf
from threading import Lock
from typing import TYPE_CHECKING, Any, cast

from goalwire.codec import cdr
from goalwire.entities.actions.client_goal import ClientGoal, ClientGoalHandle, FeedbackQueue
from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.entities.actions.goal_ids import goal_id_bytes
from goalwire.entities.actions.requests import LATE_S, ActionRequest, GoalRequest, RawFuture, ResultWait
from goalwire.entities.client import NO_REASON, PENDING_LIMIT, REASONS_LIMIT, unanswered
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.exceptions import InvalidHandle, ShutDownError
from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ActionSupport, MessageSupport, ServiceSupport
from goalwire.errors import CallError, ClosedError, RemoteError, TooManyCallsError
from goalwire.execution.blocking import block_on
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.future import Future
from goalwire.execution.inbox import Arrivals, Inbox
from goalwire.logging import get_logger
from goalwire.protocol.goals import effects as effect
from goalwire.protocol.goals import wire
from goalwire.protocol.goals.client import REMEMBERED, GoalClient
from goalwire.protocol.goals.ids import NO_ID, GoalId, new_goal_id
from goalwire.protocol.goals.status import decode_status_array
from goalwire.protocol.goals.table import GoalStatus
from goalwire.protocol.latencies import Latencies
from goalwire.protocol.qos import QoS
from goalwire.protocol.time import S_TO_NS, Time
from goalwire.transport.contract import ClientPort, EndpointKind, Payload, Port, Sample

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time as StampMessage

    from goalwire.entities.call_terms import CallTerms
    from goalwire.entities.guard import Guard
    from goalwire.entities.server_line import ServerLine
    from goalwire.protocol.statistics import ActionClientStatistics

LINGERING_LIMIT = 1000
"""Goals given up, of one client, that are cancelled where a server takes them late."""

FEEDBACK_LIMIT = 1000
"""Feedback messages that may wait for one goal's callback; the oldest is dropped and counted."""

_STATUS_LIMIT = 10
"""Status arrays that may wait. More than one: a goal whose result is not kept is in a single array."""


Effects = list[effect.ClientEffect[Any, RawFuture, Payload]]


class ActionClientCore:
    """One action client."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        group: CallbackGroup,
        qos: ActionQoS | None = None,
    ) -> None:
        self.node = node
        self.support = support
        self.name = name
        qos = qos or ActionQoS()
        self._group = group
        self._logger = get_logger(node.logger_name).get_child('action_client')
        self._lock = Lock()
        self._reactor: GoalClient[Any, RawFuture, Payload] = GoalClient()
        self._goals: dict[GoalId, ClientGoal] = {}
        self._ended: OrderedDict[GoalId, ClientGoal] = OrderedDict()
        self._reported: set[tuple[str, str]] = set()
        self.requests: dict[ActionRequest, None] = {}
        """Those to take or cancel goals that wait for their answers, or for a server."""
        self.lingering: dict[GoalRequest, None] = {}
        """Goals that were given up before a server had answered, not long ago."""
        self.call_timeout: float | None = None
        """s until a goal is accepted, or a cancel request answered; None: what the node says."""
        self._line: ServerLine | None = None
        self._result_requests: dict[GoalId, int] = {}
        """The numbers on the wire of the requests for results that are under way."""
        self._destroyed = False
        self._feedback = self._feedback_dropped = 0
        self._acceptances, self._durations = Latencies(), Latencies()
        self._now = node.context.lifeline.clock.system_now
        self._goal_class: type = support.cls.Goal  # type: ignore[attr-defined]
        self._encode_goal = cdr.encoder(self._goal_class)
        self._names = names = node.resolve_action(name)
        self._send_port = self._client(names.send_goal, support.send_goal, qos.goal)
        self._result_port = self._client(names.get_result, support.get_result, qos.result)
        self._cancel_port = self._client(names.cancel_goal, support.cancel_goal, qos.cancel)
        self._arrivals = Arrivals(node.home, self)
        self._statuses: Inbox[Sample] = Inbox(node.home, group, self._on_status, depth=_STATUS_LIMIT)
        self._feedback_port = self._subscription(
            names.feedback, support.feedback, qos.feedback, self._deliver_feedback
        )
        self._status_port = self._subscription(names.status, support.status, qos.status, self._deliver_status)
        node.own(self)

    def _client(self, name: str, support: ServiceSupport, qos: QoS) -> ClientPort:
        return self.node.port.client(describe_endpoint(self.node, EndpointKind.CLIENT, name, support, qos))

    def _subscription(
        self, name: str, support: MessageSupport, qos: QoS, deliver: Callable[[Sample], None]
    ) -> Port:
        endpoint = describe_endpoint(self.node, EndpointKind.SUBSCRIPTION, name, support, qos)
        return self.node.port.subscription(endpoint, deliver)

    # -- sending -------------------------------------------------------------------------------------------

    def send(
        self, goal: Any, feedback_callback: Callable[[Any], object] | None = None, goal_uuid: Any = None
    ) -> Future[ClientGoalHandle[Any, Any, Any]]:
        """Send a goal; the future gives its ClientGoalHandle, accepted or not.

        Raises TypeError for another type than the action's Goal, EncodeError where a field cannot go on the
        wire, GoalIdTaken for an id that is under way, TooManyCallsError, InvalidHandle once destroyed.
        """
        goal_id = new_goal_id() if goal_uuid is None else goal_id_bytes(goal_uuid)
        feedback = None if feedback_callback is None else self._feedback_inbox(feedback_callback)
        return self.send_as(goal_id, goal, feedback)

    def send_as(
        self, goal_id: GoalId, goal: Any, feedback: FeedbackQueue | None, terms: CallTerms | None = None
    ) -> Future[ClientGoalHandle[Any, Any, Any]]:
        """Send a goal; feedback goes to the queue, as it comes from the wire. Raises as `send` does.

        With terms, or a `default_timeout`, the future ends with a typed error where nobody answers, and a
        goal that is accepted too late is cancelled.
        """
        if not isinstance(goal, self._goal_class):
            raise TypeError(f'Expected {self._goal_class}, got {type(goal)}')
        self._check_alive()
        self._make_room()
        payload = wire.wrap(goal_id, self._encode_goal(goal))
        record = ClientGoal(goal_id, feedback, self._now())
        with self._lock:
            self._reactor.on_send(goal_id)
            self._ended.pop(goal_id, None)
            self._goals[goal_id] = record
        future = RawFuture(
            self,
            lambda raw: ClientGoalHandle(self, record, self.support.send_goal.decode_response(raw)),
            terms or self.new_terms(),
        )
        try:
            GoalRequest(self, self._send_port, payload, future, record).begin()
        except BaseException:
            self.drop(record, '')
            raise
        return future

    def _make_room(self) -> None:
        """Raise TooManyCallsError where too many requests wait; forget goals of which nobody asks the end."""
        if len(self.requests) >= PENDING_LIMIT:
            raise TooManyCallsError(
                f"cannot use the action '{self.full_name}': {PENDING_LIMIT} requests of this client wait for "
                'answers already; give goals a timeout, or wait for some of them first'
            )
        if len(self._goals) >= PENDING_LIMIT:
            with self._lock:
                crowded_out = self._reactor.on_crowd()
            if crowded_out is None:
                raise TooManyCallsError(
                    f"cannot send a goal to '{self.full_name}': {PENDING_LIMIT} goals of this client are "
                    'under way already; wait for the results of some of them first'
                )
            self._forget(crowded_out)

    def request(
        self,
        port: ClientPort,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Hand a request to the wire and return its number. Raises InvalidHandle, ShutDownError."""
        try:
            return port.request(payload, on_reply, on_end, timeout_ns)
        except ClosedError:
            self._check_alive()
            raise ShutDownError(f"cannot use the action '{self.name}'") from None

    def guard(self, terms: CallTerms, request: ActionRequest) -> Guard:
        """Make what sees to the end of a request that has terms."""
        from goalwire.entities.guard import Guard
        from goalwire.entities.server_line import ServerLine

        line = self._line
        if line is None:
            line = self._line = ServerLine(self.node.context, self.server_is_there, self.goal_service)
        return Guard(terms, line, request, waits=request.waits)

    def new_terms(self, timeout: float | None = None) -> CallTerms | None:
        """Terms for a request that may take `timeout` s, else the `default_timeout`; None without either."""
        limit = self.default_timeout if timeout is None else timeout
        if limit is None:
            return None
        from goalwire.entities.call_terms import CallTerms

        return CallTerms(self.node.context, 'action', self.full_name, limit)

    @property
    def default_timeout(self) -> float | None:
        """s until a goal is accepted or a cancel request answered: the client's, node's or context's."""
        own = self.call_timeout
        return self.node.default_timeout if own is None else own

    def give_up(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Wait no longer for a server to take a goal; where one does so yet, it is cancelled."""
        if isinstance(sending, RawFuture) and isinstance(sending.request, GoalRequest):
            sending.request.give_up()

    def linger(self, request: GoalRequest) -> None:
        """Keep an ear open for a goal that was given up: the latest few."""
        self.lingering[request] = None
        if len(self.lingering) > LINGERING_LIMIT:
            next(iter(self.lingering)).let_go()

    def _feedback_inbox(self, callback: Callable[[Any], object]) -> Inbox[Sample]:
        decode = self.support.feedback.decode

        def handle(sample: Sample) -> object:
            try:
                message = decode(sample.payload)
            except RemoteError as error:
                self._logger.error(f"Action '{self.name}': a feedback message was rejected ({error})")
                return None
            return callback(message)

        return Inbox(self.node.home, self._group, handle, depth=FEEDBACK_LIMIT)

    def on_goal_reply(self, record: ClientGoal, future: RawFuture, sample: Sample) -> None:
        """A server has accepted or refused a goal."""
        with self._lock:
            effects = self._reactor.on_goal_reply(record.goal_id, wire.is_acceptance(sample.payload))
        for item in effects:
            match item:
                case effect.UnexpectedReply():
                    self._logger.warning(
                        'Ignoring unexpected goal response. There may be more than one action server '
                        f"for the action '{self.name}'"
                    )
                    return
                case effect.GoalRejected():
                    self._goals.pop(record.goal_id, None)
        record.answered = True
        self._acceptances.add(sample.received_timestamp - record.sent_at)
        self.complete(future, sample.payload)

    def drop(self, record: ClientGoal, reason: str) -> None:
        """Forget a goal that no server has taken."""
        self._goals.pop(record.goal_id, None)
        self._apply(self._reactor.on_send_failed, record.goal_id, unanswered('goal', reason))

    # -- what the server tells -----------------------------------------------------------------------------

    def _deliver_feedback(self, sample: Sample) -> None:
        goal_id = bytes(sample.payload[4:20])
        goal = self._goals.get(goal_id) or self._ended.get(goal_id)
        if goal is None:
            return
        self._feedback += 1
        if goal.heard is not None:
            goal.heard()
        if goal.feedback is not None:
            goal.feedback.deliver(sample)

    def _deliver_status(self, sample: Sample) -> None:
        self._statuses.deliver(sample)

    def _on_status(self, sample: Sample) -> None:
        try:
            statuses = decode_status_array(bytes(sample.payload))
        except RemoteError as error:
            self._logger.error(f"Action '{self.name}': a status message was rejected ({error})")
            return
        self._apply(self._reactor.on_status, statuses)

    def _apply(self, event: Callable[..., Effects], *args: Any) -> None:
        """Feed the reactor and perform what it decides."""
        with self._lock:
            effects = event(*args)
        for item in effects:
            match item:
                case effect.StatusChanged(goal_id, status):
                    self._advance(goal_id, status)
                case effect.RequestResult(goal_id):
                    self._request_result(goal_id)
                case effect.DeliverResult(waiter, _, payload):
                    self.complete(waiter, payload)
                case effect.FailResult(waiter, error):
                    self._on_failed(waiter, error)

    def complete(self, future: RawFuture, payload: Payload) -> None:
        """Give a future what it waits for."""
        if future.pending() and not future.set_raw(payload):  # else it was cancelled
            self._arrivals.deliver(None)

    def _advance(self, goal_id: GoalId, status: GoalStatus) -> None:
        goal = self._goals.get(goal_id) or self._ended.get(goal_id)
        if goal is None:
            return
        goal.advance(status)
        if status.is_terminal:
            self._forget(goal_id)

    def _forget(self, goal_id: GoalId) -> None:
        """Keep a goal that has ended, or was lost, for feedback that was overtaken: the latest few."""
        with self._lock:
            goal = self._goals.get(goal_id)
            if goal is None:
                return
            self._ended[goal_id] = goal  # first: feedback is looked up under no lock, here or there
            self._goals.pop(goal_id, None)  # another thread may destroy the client meanwhile
            if len(self._ended) > REMEMBERED:
                self._feedback_dropped += self._ended.popitem(last=False)[1].dropped

    # -- results and cancelling ----------------------------------------------------------------------------

    def get_result(self, goal_id: GoalId, terms: CallTerms | None = None) -> Future[Any]:
        """Ask for a goal's result; the future gives the action's GetResult response."""
        self._check_alive()
        make = self.support.get_result.decode_response
        future = RawFuture(self, make, terms or self._terms_of_results())
        future.request = ResultWait(self, goal_id, future)
        self._apply(self._reactor.on_result_request, goal_id, future)
        return future

    def give_result_up(self, goal_id: GoalId, future: RawFuture) -> None:
        """Complete this future no more. With the last one that waits for it the request is forgotten, too."""
        with self._lock:
            is_last = self._reactor.on_result_given_up(goal_id, future)
            sequence = self._result_requests.pop(goal_id, 0) if is_last else 0
        if is_last:
            self._forget(goal_id)
        if sequence:
            self._result_port.forget(sequence)

    def _request_result(self, goal_id: GoalId) -> None:
        answered = ended = False

        def on_reply(sample: Sample) -> None:
            nonlocal answered
            if answered:
                return
            with self._lock:
                answered = True
                self._result_requests.pop(goal_id, None)
            payload, reason = wire.split_reason(sample.payload)
            status = wire.status_of(payload)
            goal = self.goal(goal_id)
            goal.reason = reason
            if goal.sent_at:
                self._durations.add(sample.received_timestamp - goal.sent_at)
            self._forget(goal_id)  # before anybody hears of the end, who may look at what is left
            self._apply(self._reactor.on_result, goal_id, status, payload)
            self._advance(goal_id, status)

        def on_end(reason: str) -> None:
            nonlocal ended
            with self._lock:
                ended = True
                if not answered:
                    self._result_requests.pop(goal_id, None)
            if not answered:
                self._forget(goal_id)
                self._apply(self._reactor.on_result_failed, goal_id, unanswered('result', reason))
                self.report_lost('result', reason)

        try:
            payload = wire.encode_result_request(goal_id)
            sequence = self.request(self._result_port, payload, on_reply, on_end)
        except BaseException:  # nothing was sent: the next who asks tries again
            self._apply(self._reactor.on_result_failed, goal_id, unanswered('result', ''))
            raise
        with self._lock:
            wanted = self._reactor.wants_result(goal_id)
            if wanted and not (answered or ended):
                self._result_requests[goal_id] = sequence
        if not wanted:
            self._result_port.forget(sequence)  # given up, or answered, before its number was known

    def cancel_goal(self, goal_id: GoalId, stamp_ns: int = 0, terms: CallTerms | None = None) -> Future[Any]:
        """Ask for cancellation; the future gives an action_msgs/srv/CancelGoal response."""
        self._check_alive()
        make = self.support.cancel_goal.decode_response
        future = RawFuture(self, make, terms or self.new_terms())
        payload = wire.encode_cancel_request(goal_id, stamp_ns)
        ActionRequest(self, self._cancel_port, payload, future).begin()
        return future

    def call_off(self, goal_id: GoalId) -> None:
        """Ask for cancellation, whatever the server says to that."""
        with suppress(ClosedError):
            asked = self.cancel_goal(goal_id, terms=self.new_terms(LATE_S))
            asked.add_waker(lambda: cast('None', asked.exception()))  # looked at

    def cancel_all_goals_async(self) -> Future[CancelGoal.Response]:
        """Ask the server to cancel every goal, whoever has sent it; the future tells which it does."""
        return self.cancel_goal(NO_ID)

    def cancel_goals_before_async(self, stamp: Time | StampMessage) -> Future[CancelGoal.Response]:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises ValueError for a time that is not above 0, which would stand for all goals.
        """
        stamp_ns = stamp.nanoseconds if isinstance(stamp, Time) else stamp.sec * S_TO_NS + stamp.nanosec
        if stamp_ns <= 0:
            raise ValueError(f'a time above 0 is needed, not {stamp}; cancel_all_goals cancels all')
        return self.cancel_goal(NO_ID, stamp_ns)

    def cancel_all_goals(self) -> CancelGoal.Response | None:
        """Ask as `cancel_all_goals_async` does, and wait; None where the context ends before that."""
        answer: CancelGoal.Response | None = self.wait_for(self.cancel_all_goals_async)
        return answer

    def cancel_goals_before(self, stamp: Time | StampMessage) -> CancelGoal.Response | None:
        """Ask as `cancel_goals_before_async` does, and wait; None where the context ends before that."""
        answer: CancelGoal.Response | None = self.wait_for(lambda: self.cancel_goals_before_async(stamp))
        return answer

    def wait_for(self, ask: Callable[[], Future[Any]]) -> Any:
        """Ask the server, block until the answer is there and return it; needs no executor.

        Raises WouldDeadlockError, with nothing asked, where the answer needs the thread that would wait.
        """
        self.node.context.local_servers.check(self.node.graph, self._names.send_goal)
        future = ask()
        block_on(future, None, self.node.context.lifeline)
        return future.result()

    def _terms_of_results(self) -> CallTerms | None:
        """A goal may run for ever: where calls have a time, its result has none, but typed errors."""
        terms = self.new_terms(inf if self.default_timeout is not None else None)
        if terms is not None:
            terms.see_servers(self.goal_service)
        return terms

    def _on_failed(self, future: RawFuture, error: Exception) -> None:
        """No result will come. Without terms the future stays pending, as in ROS 2, and a warning tells."""
        terms = future.terms
        if terms is None or not future.pending():
            return
        if self._destroyed:
            future.set_exception(InvalidHandle())
        elif not self.node.context.ok():
            future.set_exception(ShutDownError(terms.title))
        else:
            future.set_exception(terms.retold(error) if isinstance(error, CallError) else error)

    def report_lost(self, what: str, reason: str) -> None:
        """Say once for each kind of request, and each of the first reasons, that nobody will answer it."""
        if self._destroyed or not self.node.context.ok() or self.default_timeout is not None:
            return  # it is this side that goes, or errors tell
        if (what, reason) in self._reported or len(self._reported) == REASONS_LIMIT:
            return
        self._reported.add((what, reason))
        self._logger.warning(
            f"Action '{self.name}': no server answered the {what} ({reason or NO_REASON}). The "
            'future stays pending, as in ROS 2: call wait_for_server() first, and wait with a timeout'
        )

    # -- the server, and the end -----------------------------------------------------------------------------

    def server_is_there(self) -> bool:
        """True while the graph shows all five parts of a server; False once destroyed.

        Raises ShutDownError after the context's end.
        """
        if self._destroyed:
            return False
        self.node.check_open()
        if not self.node.graph.has_action(self._names.name, self.type_name):
            return False
        return all(port.reaches_server() for port in (self._send_port, self._result_port, self._cancel_port))

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""
        return self._names.name

    @property
    def goal_service(self) -> str:
        """The fully-qualified name of the service that takes goals."""
        return self._names.send_goal

    @property
    def goal_type(self) -> type:
        """The action's Goal class."""
        return self._goal_class

    @property
    def type_name(self) -> str:
        """'pkg/action/Name'."""
        return self.support.send_goal.type_name.removesuffix('_SendGoal')

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until there is a server (True) or the time is over (False); None waits without limit."""
        return wait_for_graph(self.node.context, self.server_is_there, timeout_sec)

    def goal(self, goal_id: GoalId) -> ClientGoal:
        """What is kept of a goal; something new where nothing is."""
        return self._goals.get(goal_id) or self._ended.get(goal_id) or ClientGoal(goal_id, None)

    def inboxes(self) -> list[Inbox[Any]]:
        """Where statuses and the feedback of each goal wait for the executor."""
        goals = (*self._goals.copy().values(), *self._ended.copy().values())
        return [self._statuses, *(goal.feedback for goal in goals if isinstance(goal.feedback, Inbox))]

    def statistics(self) -> ActionClientStatistics:
        """Count goals and feedback."""
        from goalwire.protocol.statistics import ActionClientStatistics

        with self._lock:
            goals = self._reactor.statistics()
            kept = (*self._goals.copy().values(), *self._ended.values())
        return ActionClientStatistics(
            self.full_name,
            goals,
            self._feedback,
            self._feedback_dropped + sum(goal.dropped for goal in kept),
            self._acceptances.histogram(),
            self._durations.histogram(),
        )

    @property
    def destroyed(self) -> bool:
        """True once destroyed."""
        return self._destroyed

    def _check_alive(self) -> None:
        if self._destroyed:
            raise InvalidHandle

    def destroy(self) -> None:
        """Undeclare; futures that are pending stay so, as in ROS 2. Idempotent."""
        if self._destroyed:
            return
        self._destroyed = True
        self.node.disown(self)
        for request in (*self.lingering,):
            request.let_go()
        for asked in (*self.requests,):
            if asked.guard is not None:
                asked.guard.fail(InvalidHandle())
        for port in (
            self._feedback_port,
            self._status_port,
            self._send_port,
            self._result_port,
            self._cancel_port,
        ):
            port.close()
        self._statuses.close()
        self._arrivals.close()
        self._apply(self._reactor.on_close, InvalidHandle())
        for goal in (*self._goals.values(), *self._ended.values()):
            if goal.feedback is not None:
                goal.feedback.close()
        self.requests.clear()
        self._goals.clear()
        self._result_requests.clear()
        self._ended.clear()
