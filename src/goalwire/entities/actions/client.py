"""An action client: sends goals and completes the futures of what the server answers.

The rules are in goalwire.rules.goals.client. Replies complete futures on the thread that brings them, so
that no executor is needed to wait; feedback and statuses go through the executor, in the client's group.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import TYPE_CHECKING, Any

from goalwire.cdr import codec
from goalwire.entities.actions.client_cancelling import Cancelling
from goalwire.entities.actions.client_goal import ClientGoal, ClientGoalHandle, FeedbackQueue
from goalwire.entities.actions.client_goals import ClientGoals
from goalwire.entities.actions.client_results import ClientResults
from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.entities.actions.goal_feedback import GoalFeedback
from goalwire.entities.actions.requests import EncodedResponseFuture, GoalRequest
from goalwire.entities.actions.types import goal_id_bytes
from goalwire.entities.callbacks import check_callback
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.node import NodeCore
from goalwire.entities.pending_call import PENDING_LIMIT, unanswered
from goalwire.entities.type_support import ActionSupport, MessageSupport
from goalwire.errors import InvalidHandle, RemoteError, TooManyCallsError
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.future import Future
from goalwire.rules.goals import effects as effect
from goalwire.rules.goals import wire
from goalwire.rules.goals.ids import GoalId, new_goal_id
from goalwire.rules.goals.status import statuses_of
from goalwire.rules.latencies import Latencies
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, Port, Sample
from goalwire.transport.reports import log_rejected

if TYPE_CHECKING:
    from goalwire.entities.actions.client_goals import Effects
    from goalwire.entities.call_context import CallContext
    from goalwire.rules.statistics import ActionClientStatistics

LINGERING_LIMIT = 1000
"""Goals given up, of one client, that are cancelled where a server takes them late."""

_STATUS_LIMIT = 10
"""Status arrays that may wait. More than one: a goal whose result is not kept is in a single array."""


class ActionClientCore(Cancelling):
    """One action client."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        group: CallbackGroup,
        qos: ActionQoS | None = None,
    ) -> None:
        qos = qos or ActionQoS()
        super().__init__(node, support, name, qos)
        self._group = group
        self.goals = ClientGoals()
        self._results = ClientResults(self, self._result_port)
        self.lingering: dict[GoalRequest, None] = {}
        """Goals that were given up before a server had answered, not long ago."""
        self._feedback = 0
        self._feedback_rejected = 0
        self._statuses_rejected = 0
        self._acceptances = Latencies()
        self._clock = node.context.shutdown_signal.clock
        self._goal_class = self.goal_type
        self._encode_goal = codec.encoder(self._goal_class)
        names = self._names
        self._statuses: EventQueue[Sample] = EventQueue(
            node.work_queue, group, self._on_status, depth=_STATUS_LIMIT
        )
        self._feedback_port = self._subscription(
            names.feedback, support.feedback, qos.feedback, self._deliver_feedback
        )
        self._status_port = self._subscription(
            names.status, support.status, qos.status, self._statuses.deliver
        )
        node.own(self)

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

        Raises TypeError for another type than the action's Goal or a callback that cannot be called,
        EncodeError where a field cannot go on the wire, GoalIdTaken for an id that is under way,
        TooManyCallsError, InvalidHandle once destroyed.
        """
        goal_id = new_goal_id() if goal_uuid is None else goal_id_bytes(goal_uuid)
        feedback = None if feedback_callback is None else self._feedback_queue(feedback_callback)
        return self.send_as(goal_id, goal, feedback)

    def send_as(
        self,
        goal_id: GoalId,
        goal: Any,
        feedback: FeedbackQueue | None,
        call_context: CallContext | None = None,
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
        record = ClientGoal(goal_id, feedback, self._clock.system_now())
        self.goals.add(record)
        future = EncodedResponseFuture(
            self,
            lambda raw: ClientGoalHandle(self, record, self.support.send_goal.decode_response(raw)),
            call_context or self.new_terms(),
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
        if len(self.goals.active) >= PENDING_LIMIT and not self.goals.make_room():
            raise TooManyCallsError(
                f"cannot send a goal to '{self.full_name}': {PENDING_LIMIT} goals of this client are "
                'under way already; wait for the results of some of them first'
            )

    def _feedback_queue(self, callback: Callable[[Any], object]) -> GoalFeedback:
        check_callback(callback, ('feedback_message',), f"the feedback callback of the action '{self.name}'")
        decode = self.support.feedback.decode

        def handle(sample: Sample) -> object:
            try:
                message = decode(sample.payload)
            except RemoteError as error:
                self.reject_feedback(error)
                return None
            return callback(message)

        return GoalFeedback(self.node.work_queue, self._group, handle, self)

    def reject_feedback(self, error: RemoteError) -> None:
        """Count a feedback message that cannot be decoded."""
        self._feedback_rejected += 1
        self._log_rejected('feedback', self._feedback_rejected, error)

    def _log_rejected(self, kind: str, count: int, error: RemoteError) -> None:
        what = f"Action '{self.name}': a {kind} message was rejected"
        log_rejected(self._logger.name, what, count, error, is_error=True)

    def on_goal_reply(self, record: ClientGoal, future: EncodedResponseFuture, sample: Sample) -> None:
        """A server has accepted or refused a goal."""
        rules = self.goals.rules
        for item in self.goals.feed(rules.on_goal_reply, record.goal_id, wire.is_acceptance(sample.payload)):
            match item:
                case effect.UnexpectedReply():
                    self._logger.warning(
                        'Ignoring unexpected goal response. There may be more than one action server '
                        f"for the action '{self.name}'"
                    )
                    return
                case effect.GoalRejected():
                    self.goals.drop(record.goal_id)
        record.answered = True
        self._acceptances.add(sample.received_timestamp - record.sent_at)
        feedback = record.feedback
        if isinstance(feedback, GoalFeedback):
            told = not future.pending() or future.set_raw(sample.payload)
            feedback.open(in_a_turn=not told)
        else:
            self.complete(future, sample.payload)

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """Log why a goal was aborted: programs written for rclpy know of no reason, and show none."""
        self._logger.warning(f"Action '{self.name}': goal {goal_id.hex()} was aborted: {reason}")

    def hear_feedback(self) -> None:
        """Take what feedback has come by now, where the wire keeps it until somebody does."""
        self._feedback_port.catch_up()

    def drop(self, record: ClientGoal, reason: str) -> None:
        """Forget a goal that no server has taken."""
        self.goals.drop(record.goal_id)
        self.dispatch(self.goals.rules.on_send_failed, record.goal_id, unanswered('goal', reason))

    def give_up(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Wait no longer for a server to take a goal; where one does so yet, it is cancelled."""
        if isinstance(sending, EncodedResponseFuture) and isinstance(sending.request, GoalRequest):
            sending.request.give_up()

    def await_late_accept(self, request: GoalRequest) -> None:
        """Keep an ear open for a goal that was given up: the latest few."""
        self.lingering[request] = None
        if len(self.lingering) > LINGERING_LIMIT:
            next(iter(self.lingering)).let_go()

    # -- what the server tells -----------------------------------------------------------------------------

    def _deliver_feedback(self, sample: Sample) -> None:
        goal_id = bytes(sample.payload[4:20])
        goal = self.goals.active.get(goal_id) or self.goals.ended.get(goal_id)  # `find`, but for a call
        if goal is None:
            return
        self._feedback += 1
        if goal.heard is not None:
            goal.heard()
        if goal.feedback is not None:
            goal.feedback.deliver(sample)

    def _on_status(self, sample: Sample) -> None:
        with self.goals.lock:
            followed = self.goals.rules.followed()
        try:
            statuses = statuses_of(followed, bytes(sample.payload))
        except RemoteError as error:
            self._statuses_rejected += 1
            self._log_rejected('status', self._statuses_rejected, error)
            return
        self.dispatch(self.goals.rules.on_status, statuses)

    def dispatch(self, event: Callable[..., Effects], *args: Any) -> None:
        """Feed the rules and perform what they decide."""
        for item in self.goals.feed(event, *args):
            match item:
                case effect.StatusChanged(goal_id, status):
                    self.goals.advance(goal_id, status)
                case effect.RequestResult(goal_id):
                    self._results.request(goal_id)
                case effect.DeliverResult(waiter, _, payload):
                    self.complete(waiter, payload)
                case effect.FailResult(waiter, error):
                    self._results.fail(waiter, error)

    def get_result(self, goal_id: GoalId, call_context: CallContext | None = None) -> Future[Any]:
        """Ask for a goal's result; the future gives the action's GetResult response."""
        self._check_alive()
        return self._results.get(goal_id, call_context or self._terms_of_results())

    def _terms_of_results(self) -> CallContext | None:
        """A goal may run for ever: where calls have a time, its result has none, but typed errors."""
        call_context = self.new_terms(inf if self.default_timeout is not None else None)
        if call_context is not None:
            call_context.see_servers(self.goal_service)
        return call_context

    # -- what is kept, and the end -------------------------------------------------------------------------

    def goal(self, goal_id: GoalId) -> ClientGoal:
        """What is kept of a goal; something new where nothing is."""
        return self.goals.known(goal_id)

    def event_queues(self) -> list[EventQueue[Any]]:
        """Where statuses and the feedback of each goal wait for the executor."""
        queues = self.goals.feedback_queues
        return [self._statuses, *(queue for queue in queues if isinstance(queue, EventQueue))]

    def statistics(self) -> ActionClientStatistics:
        """Count goals and feedback."""
        from goalwire.rules.statistics import ActionClientStatistics

        with self.goals.lock:
            counted = self.goals.rules.statistics()
        return ActionClientStatistics(
            self.full_name,
            counted,
            self._feedback,
            self.goals.feedback_dropped,
            self._acceptances.histogram(),
            self._results.durations.histogram(),
            self._feedback_rejected + self._statuses_rejected,
        )

    def destroy(self) -> None:
        """Undeclare; futures that are pending stay so, as in ROS 2. Idempotent."""
        if self._destroyed:
            return
        self._destroyed = True
        self.node.disown(self)
        for request in (*self.lingering,):
            request.let_go()
        self._feedback_port.close()
        self._status_port.close()
        self._close_calls()
        self._statuses.close()
        self.dispatch(self.goals.rules.on_close, InvalidHandle())
        self.goals.close()
        self._results.close()
