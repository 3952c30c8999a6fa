"""An action client: sends goals and completes the futures of what the server answers.

The rules, and the one record of each goal, are in goalwire.rules.goals.client; the requests in requests.py.
Replies complete futures on the thread that brings them, so that no executor is needed to wait. The acceptance
of a goal whose server runs in the client's own executor waits for its turn there instead: see `_answers`.
Feedback and statuses go through the executor, in the client's group.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from math import inf
from threading import Lock
from typing import TYPE_CHECKING, Any, NoReturn, cast
from weakref import ReferenceType, ref

from goalwire.cdr import codec
from goalwire.entities.actions.client_goal import ClientGoalHandle, GoalFeedback, ResultFuture
from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.entities.actions.requests import LATE_S, ActionRequests, CancelCall, GoalCall, ResultCall
from goalwire.entities.actions.types import goal_id_bytes
from goalwire.entities.call_context import CallContext, TimedCalls
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.graph_waiting import ServerWaitQueue, tell_near_misses, wait_for_graph
from goalwire.entities.node import NodeCore
from goalwire.entities.pending_call import PENDING_LIMIT, end_with, unanswered
from goalwire.entities.type_support import ActionSupport, MessageSupport
from goalwire.errors import (
    CallError,
    ClosedError,
    InvalidHandle,
    RemoteError,
    ShutDownError,
    TooManyCallsError,
    peer_text,
)
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.callbacks import advise_callback
from goalwire.execution.event_queue import EventQueue, ResponseTicks
from goalwire.execution.future import Future, block_on, cancel_quietly
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.reports import log_rejected
from goalwire.rules.goals import effects as effect
from goalwire.rules.goals import wire
from goalwire.rules.goals.client import ClientGoal, GoalClient
from goalwire.rules.goals.ids import NO_ID, GoalId, new_goal_id
from goalwire.rules.latencies import Latencies
from goalwire.rules.qos import QoS
from goalwire.rules.time import S_TO_NS, Time
from goalwire.transport.contract import EndpointKind, Payload, Port, Sample

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time as StampMessage

    from goalwire.rules.goals.client import FeedbackQueue
    from goalwire.rules.statistics import ActionClientStatistics

    Effects = list[effect.ClientEffect[ResultFuture, Payload]]

_STATUS_LIMIT = 10
"""Status arrays that may wait. More than one: a goal whose result is not kept is in a single array."""


class ActionClientCore(TimedCalls):
    """One action client: three clients, for goals, cancelling and results, and two subscriptions.

    Its `call_timeout` ends with a goal's acceptance.
    """

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        group: CallbackGroup,
        qos: ActionQoS | None = None,
    ) -> None:
        qos = qos or ActionQoS()
        self.node = node
        self.support = support
        self.name = name
        self.destroyed = False
        self.goals: GoalClient[ResultFuture, Payload] = GoalClient()
        """The rules, and the record of each goal."""
        self.blocking: dict[Future[Any], None] = {}
        """The futures for which threads wait in a blocking call."""
        self._lock = Lock()
        """Guards `goals`: the rules take no lock themselves."""
        self._group = group
        self.logger: RcutilsLogger = get_logger(node.logger_name).get_child('action_client')
        self._told = ''
        """The hint about similar names and types that was logged last."""
        self._feedback = 0
        self._feedback_rejected = 0
        self._statuses_rejected = 0
        self._result_latencies = Latencies()
        """From goals to their results."""
        self._clock = node.context.shutdown_signal.clock
        self.goal_type: type = support.cls.Goal  # type: ignore[attr-defined]
        """The action's Goal class."""
        self._encode_goal = codec.encoder(self.goal_type)
        self._wait_queue: ServerWaitQueue | None = None
        self.arrivals = ResponseTicks(node.work_queue, self)
        self._names = node.resolve_action(name)
        self._answers: EventQueue[tuple[GoalCall, Payload]] = EventQueue(
            node.work_queue, None, self._answer_in_turn
        )
        """Acceptances that wait for their turn: the execution of the goal begins first, as in rclpy."""
        self._statuses: EventQueue[Sample] = EventQueue(
            node.work_queue, group, self._on_status, depth=_STATUS_LIMIT
        )
        with ExitStack() as undo:
            self._open(undo, support, qos)
            undo.pop_all()
        node.own(self)

    def _open(self, undo: ExitStack, support: ActionSupport, qos: ActionQoS) -> None:
        """Declare everything. If one declaration fails, `undo` takes back those before it."""
        names = self._names
        self.goal_requests = ActionRequests(self, 'goal', names.send_goal, support.send_goal, qos.goal)
        undo.callback(self.goal_requests.close)
        self.result_requests = ActionRequests(
            self, 'result', names.get_result, support.get_result, qos.result
        )
        undo.callback(self.result_requests.close)
        self.cancel_requests = ActionRequests(
            self, 'cancel request', names.cancel_goal, support.cancel_goal, qos.cancel
        )
        undo.callback(self.cancel_requests.close)
        deliver_feedback = partial(ActionClientCore._deliver_feedback, ref(self))
        self._feedback_port = self._subscription(
            names.feedback, support.feedback, qos.feedback, deliver_feedback
        )
        undo.callback(self._feedback_port.close)
        self._status_port = self._subscription(
            names.status, support.status, qos.status, self._statuses.deliver
        )

    def _subscription(
        self, name: str, support: MessageSupport, qos: QoS, deliver: Callable[[Sample], None]
    ) -> Port:
        endpoint = describe_endpoint(self.node, EndpointKind.SUBSCRIPTION, name, support, qos)
        return self.node.port.subscription(endpoint, deliver)

    # -- the rules, and what they decide -------------------------------------------------------------------

    def dispatch(self, event: Callable[..., Effects], *args: Any) -> None:
        """Pass an event to the reactor and perform its effects."""
        with self._lock:
            effects = event(*args)
        for item in effects:
            match item:
                case effect.StatusChanged(goal_id, _):
                    goal = self.goals.active.get(goal_id) or self.goals.ended.get(goal_id)
                    if goal is not None and goal.heard is not None:
                        goal.heard()
                case effect.RequestResult(goal_id):
                    self._request_result(goal_id)
                case effect.DeliverResult(future, _, payload):
                    if future.pending() and not future.set_raw(payload):  # else it was cancelled
                        self.arrivals.deliver(None)
                case effect.FailResult(future, error):
                    self._fail_result(future, error)

    def goal(self, goal_id: GoalId) -> ClientGoal[ResultFuture]:
        """Return the record of a goal; a new one, of an UNKNOWN goal, if there is none."""
        return self.goals.find(goal_id) or ClientGoal(goal_id)

    # -- sending -------------------------------------------------------------------------------------------

    def send(
        self, goal: Any, feedback_callback: Callable[[Any], object] | None = None, goal_uuid: Any = None
    ) -> Future[ClientGoalHandle[Any, Any, Any]]:
        """Send a goal; the future gives its ClientGoalHandle, accepted or not.

        Raises TypeError for another type than the action's Goal,
        EncodeError if a field cannot go on the wire, GoalIdTaken for an id that is under way,
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

        With a context, or a `default_timeout`, the future ends with a typed error if nobody answers, and a
        goal that is accepted too late is cancelled.
        """
        if not isinstance(goal, self.goal_type):
            raise TypeError(f'Expected {self.goal_type}, got {type(goal)}')
        if self.destroyed:
            raise InvalidHandle
        self._make_room()
        payload = wire.wrap(goal_id, self._encode_goal(goal))
        with self._lock:
            record = self.goals.on_send(goal_id, feedback, self._clock.system_now())

        def decode(raw: Payload) -> ClientGoalHandle[Any, Any, Any]:
            return ClientGoalHandle(self, record, self.support.send_goal.decode_response(raw))

        call = GoalCall(self.goal_requests, record, decode)
        try:
            self.goal_requests.start(call, payload, call_context or self._new_context())
        except BaseException:
            self.discard_goal(record, '')
            raise
        return call

    def _make_room(self) -> None:
        """Put a goal away if need be. Raises TooManyCallsError if too many requests or goals wait."""
        requests = self.goal_requests
        if len(requests.pending) >= PENDING_LIMIT or len(requests.timed) >= PENDING_LIMIT:
            raise TooManyCallsError(
                f"cannot use the action '{self.full_name}': {PENDING_LIMIT} requests of this client wait for "
                'answers already; give goals a timeout, or wait for some of them first'
            )
        if len(self.goals.active) < PENDING_LIMIT:
            return
        with self._lock:
            is_room = self.goals.on_crowd()
        if not is_room:
            raise TooManyCallsError(
                f"cannot send a goal to '{self.full_name}': {PENDING_LIMIT} goals of this client are "
                'under way already; wait for the results of some of them first'
            )

    def _new_context(self, timeout: float | None = None) -> CallContext | None:
        """The context of a request that may take `timeout` s, or the `default_timeout`; None without both."""
        limit = self.default_timeout if timeout is None else timeout
        return None if limit is None else CallContext(self.node.context, 'action', self.full_name, limit)

    def make_wait_queue(self) -> ServerWaitQueue:
        """Return the queue in which the requests of this client wait for a server."""
        if self._wait_queue is None:
            self._wait_queue = ServerWaitQueue(self.node.context, self.server_is_there, self.goal_service)
        return self._wait_queue

    def on_goal_reply(self, call: GoalCall, sample: Sample) -> None:
        """A server has accepted or refused a goal."""
        goal, payload = call.goal, sample.payload
        with self._lock:
            (answer,) = self.goals.on_goal_reply(goal.goal_id, wire.is_acceptance(payload))
        if isinstance(answer, effect.UnexpectedReply):
            self.logger.warning(
                'Ignoring unexpected goal response. There may be more than one action server '
                f"for the action '{self.name}'"
            )
            return
        self.goal_requests.latencies.add(sample.received_timestamp - goal.sent_at)
        if call not in self.blocking and self._server_shares_executor():
            self._answers.deliver((call, payload))
            if call in self.blocking:  # by now: who blocks notes that first, and then looks at the answers
                self._answer_at_once()
        else:
            self._answer_goal(call, payload)

    def _server_shares_executor(self) -> bool:
        """Whether a server of this action runs in the executor of this client, and a thread spins that."""
        servers = self.node.context.deadlock_detector.event_queues.get(self._names.send_goal)
        if not servers:
            return False
        queue = self.node.work_queue.queue
        driver = None if queue is None else queue.driver()
        if driver is None or not driver.is_driven():
            return False
        return any(server.work_queue.queue is queue for server in servers)

    def _answer_in_turn(self, answer: tuple[GoalCall, Payload]) -> None:
        self._answer_goal(*answer)

    def _answer_at_once(self) -> None:
        """Complete what waits for its turn: a thread blocks on it, and that turn might never come."""
        while (answer := self._answers.take()) is not None:
            self._answer_goal(*answer)

    def _answer_goal(self, call: GoalCall, payload: Payload) -> None:
        """Complete the future of a goal that a server has accepted or refused, and let its feedback begin."""
        goal = call.goal
        if isinstance(goal.feedback, GoalFeedback):
            told = not call.pending() or call.set_raw(payload)
            goal.feedback.open(in_a_turn=not told)
        else:
            call.complete(payload)

    def discard_goal(self, goal: ClientGoal[ResultFuture], reason: str) -> None:
        """Keep nothing of a goal that no server has accepted."""
        self.dispatch(self.goals.on_send_failed, goal.goal_id, unanswered('goal', reason))

    def cancel_sending(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Wait no longer for a server to accept a goal. If one still does so, the goal is cancelled."""
        if isinstance(sending, GoalCall):
            sending.cancel_goal()

    # -- feedback and statuses -----------------------------------------------------------------------------

    def _feedback_queue(self, callback: Callable[[Any], object]) -> GoalFeedback:
        what = f"the feedback callback of the action '{self.name}'"
        advise_callback(callback, ('feedback_message',), what, self.logger)
        decode = self.support.feedback.decode

        def handle(sample: Sample) -> object:
            try:
                message = decode(sample.payload)
            except RemoteError as error:
                self.reject_feedback(error)
                return None
            return callback(message)

        return GoalFeedback(self.node.work_queue, self._group, handle, self)

    @staticmethod
    def _deliver_feedback(reference: ReferenceType[ActionClientCore], sample: Sample) -> None:
        # hot path: the wire does not hold the client, and yet this is one call.
        self = reference()
        if self is None:
            return
        goal_id = bytes(sample.payload[4:20])
        goal = self.goals.active.get(goal_id) or self.goals.ended.get(goal_id)  # `find`, but for a call
        if goal is None:
            return
        self._feedback += 1
        if goal.heard is not None:
            goal.heard()
        if goal.feedback is not None:
            goal.feedback.deliver(sample)

    def reject_feedback(self, error: RemoteError) -> None:
        """Count a feedback message that cannot be decoded."""
        self._feedback_rejected += 1
        self._log_rejected('feedback', self._feedback_rejected, error)

    def _on_status(self, sample: Sample) -> None:
        try:
            self.dispatch(self.goals.on_status, bytes(sample.payload))
        except RemoteError as error:
            self._statuses_rejected += 1
            self._log_rejected('status', self._statuses_rejected, error)

    def _log_rejected(self, kind: str, count: int, error: RemoteError) -> None:
        what = f"Action '{self.name}': a {kind} message was rejected"
        log_rejected(self.logger.name, what, count, error, is_error=True)

    # -- results -------------------------------------------------------------------------------------------

    def get_result(self, goal_id: GoalId, call_context: CallContext | None = None) -> Future[Any]:
        """Ask for a goal's result; the future gives the action's GetResult response."""
        if self.destroyed:
            raise InvalidHandle
        if call_context is None and self.default_timeout is not None:
            # A goal may run for ever: if calls have a time, its result has none, but typed errors.
            call_context = CallContext(self.node.context, 'action', self.full_name, inf)
            call_context.see_servers(self.goal_service)
        goal = self.goals.find(goal_id)
        feedback = None if goal is None else goal.feedback
        decode = self.support.get_result.decode_response
        future = ResultFuture(self, goal_id, decode, call_context, feedback)
        self.dispatch(self.goals.on_result_request, goal_id, future)
        return future

    def _request_result(self, goal_id: GoalId) -> None:
        """Send the request for a result that somebody wants."""
        with self._lock:
            goal = self.goals.active.get(goal_id)
            if goal is None or goal.request is not None or not goal.waiters:
                return  # no waiter is left, or it was asked for again meanwhile
            goal.request = call = ResultCall(self.result_requests, goal)
        try:
            self.result_requests.start(call, wire.encode_result_request(goal_id))
        except BaseException:  # nothing was sent: the next request tries again
            call.end()
            self.dispatch(self.goals.on_result_failed, goal_id, unanswered('result', ''))
            raise

    def cancel_result(self, future: ResultFuture) -> None:
        """Complete this future no more. With the last that waits for a result its request is cancelled."""
        with self._lock:
            request = self.goals.on_result_cancelled(future.goal_id, future)
        if request is not None:
            request.discard()

    def on_result_reply(self, call: ResultCall, sample: Sample) -> None:
        """The result is there. It is given to those that wait after the feedback that came before it."""
        goal = call.goal
        payload, reason = wire.split_reason(sample.payload)
        if reason and not goal.reason:
            goal.reason = peer_text(reason)
            self.note_failure(goal.goal_id, goal.reason)
        if goal.sent_at:
            self._result_latencies.add(sample.received_timestamp - goal.sent_at)
        if goal.feedback is not None:
            self._feedback_port.catch_up()  # the wire may still hold feedback
        status = wire.status_of(payload)
        if isinstance(goal.feedback, GoalFeedback):
            goal.feedback.end(partial(self.dispatch, self.goals.on_result, goal.goal_id, status, payload))
        else:
            self.dispatch(self.goals.on_result, goal.goal_id, status, payload)

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """Log why a goal was aborted: programs written for rclpy know of no reason, and show none."""
        self.logger.warning(f"Action '{self.name}': goal {goal_id.hex()} was aborted: {reason}")

    def on_result_lost(self, call: ResultCall, reason: str) -> None:
        """No result will come."""
        self.dispatch(self.goals.on_result_failed, call.goal.goal_id, unanswered('result', reason))
        call.awaited_by.report_unanswered(reason)

    def _fail_result(self, future: ResultFuture, error: Exception) -> None:
        """Fail one waiting future if it has a context; else it stays pending, as in ROS 2."""
        call_context = future.call_context
        if call_context is None or not future.pending():
            return
        if self.destroyed:
            end_with(future, InvalidHandle())
        elif not self.node.context.ok():
            end_with(future, ShutDownError(call_context.title))
        else:
            end_with(future, call_context.retell(error) if isinstance(error, CallError) else error)

    # -- cancelling ----------------------------------------------------------------------------------------

    def cancel_goal(
        self, goal_id: GoalId, stamp_ns: int = 0, call_context: CallContext | None = None
    ) -> Future[Any]:
        """Ask for cancellation; the future gives an action_msgs/srv/CancelGoal response."""
        if self.destroyed:
            raise InvalidHandle
        call = CancelCall(self.cancel_requests, self.support.cancel_goal.decode_response)
        payload = wire.encode_cancel_request(goal_id, stamp_ns)
        self.cancel_requests.start(call, payload, call_context or self._new_context())
        return call

    def cancel_quietly(self, goal_id: GoalId) -> None:
        """Ask for cancellation, whatever the server says to that."""
        with suppress(ClosedError):
            asked = self.cancel_goal(goal_id, call_context=self._new_context(LATE_S))
            asked.add_waker(lambda: cast('None', asked.exception()))  # looked at

    def cancel_all_goals_async(self) -> Future[CancelGoal.Response]:
        """Ask the server to cancel every goal, whoever has sent it; the future tells which it does."""
        return self.cancel_goal(NO_ID)

    def cancel_goals_before_async(self, stamp: Time | StampMessage) -> Future[CancelGoal.Response]:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises TypeError for what is no time, ValueError for one not above 0, which would stand for all goals.
        """
        if not (isinstance(stamp, Time) or hasattr(stamp, 'nanosec')):
            raise TypeError(f'a Time or a builtin_interfaces/msg/Time is needed, not {stamp!r}')
        stamp_ns = stamp.nanoseconds if isinstance(stamp, Time) else stamp.sec * S_TO_NS + stamp.nanosec
        if stamp_ns <= 0:
            raise ValueError(f'a time above 0 is needed, not {stamp}; cancel_all_goals cancels all')
        return self.cancel_goal(NO_ID, stamp_ns)

    def cancel_all_goals(self) -> CancelGoal.Response | None:
        """Ask as `cancel_all_goals_async` does, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.wait_for(self.cancel_all_goals_async)
        return answer

    def cancel_goals_before(self, stamp: Time | StampMessage) -> CancelGoal.Response | None:
        """Ask as `cancel_goals_before_async` does, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.wait_for(lambda: self.cancel_goals_before_async(stamp))
        return answer

    # -- waiting -------------------------------------------------------------------------------------------

    def wait_for(self, ask: Callable[[], Future[Any]]) -> Any:
        """Ask the server, block until the answer is there and return it; needs no executor.

        Raises WouldDeadlockError, with nothing asked, if the answer needs the thread that would wait;
        ShutDownError and InvalidHandle if the context ends, or this is destroyed, before it is there.
        """
        self.node.context.deadlock_detector.check(self.node.graph, self.goal_service)
        future = ask()
        self.blocking[future] = None
        self._answer_at_once()
        try:
            if self.destroyed or not block_on(future, None, self.node.context.shutdown_signal):
                self._refuse_after_the_end()
        except BaseException:
            cancel_quietly(future)
            raise
        finally:
            self.blocking.pop(future, None)
        try:
            return future.result()
        finally:
            del future  # its exception's traceback holds this frame

    def server_is_there(self) -> bool:
        """True while the graph shows all five parts of a server; False once destroyed.

        Raises ShutDownError after the context's end.
        """
        if self.destroyed:
            return False
        self.node.check_open()
        if not self.node.graph.has_action(self._names.name, self.type_name):
            return False
        requests = (self.goal_requests, self.result_requests, self.cancel_requests)
        return all(each.reaches_server() for each in requests)

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until there is a server (True) or the time is over (False); None waits without limit."""
        if wait_for_graph(self.node.context, self.server_is_there, timeout_sec):
            return True
        self._told = tell_near_misses(self.node, 'action', self.full_name, self._told)
        return False

    # -- what it is ----------------------------------------------------------------------------------------

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""
        return self._names.name

    @property
    def goal_service(self) -> str:
        """The fully-qualified name of the service that takes goals."""
        return self._names.send_goal

    @property
    def type_name(self) -> str:
        """'pkg/action/Name'."""
        return self.support.send_goal.type_name.removesuffix('_SendGoal')

    def event_queues(self) -> list[EventQueue[Any]]:
        """Where statuses and the feedback of each goal wait for the executor."""
        queues = self.goals.feedback_queues()
        return [self._statuses, *(queue for queue in queues if isinstance(queue, EventQueue))]

    def statistics(self) -> ActionClientStatistics:
        """Count goals and feedback."""
        from goalwire.rules.statistics import ActionClientStatistics

        with self._lock:
            counted, dropped = self.goals.statistics(), self.goals.feedback_dropped
        return ActionClientStatistics(
            self.full_name,
            counted,
            self._feedback,
            dropped,
            self.goal_requests.latencies.histogram(),
            self._result_latencies.histogram(),
            self._feedback_rejected + self._statuses_rejected,
        )

    # -- the end -------------------------------------------------------------------------------------------

    def _refuse_after_the_end(self) -> NoReturn:
        if self.destroyed:
            raise InvalidHandle
        raise ShutDownError(f"action '{self.full_name}'")

    def destroy(self) -> None:
        """Undeclare; futures that are pending stay so, as in ROS 2, but for those with a time. Idempotent."""
        if self.destroyed:
            return
        self.destroyed = True
        self.node.disown(self)
        self._feedback_port.close()
        self._status_port.close()
        for requests in (self.goal_requests, self.result_requests, self.cancel_requests):
            requests.close()
        for future in (*self.blocking,):
            if future.pending():
                end_with(future, InvalidHandle())
        self._statuses.close()
        queues = self.goals.feedback_queues()
        self.dispatch(self.goals.on_close, InvalidHandle())
        for queue in queues:
            queue.close()
