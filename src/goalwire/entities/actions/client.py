"""An action client: sends goals and completes futures with the server's answers.

The rules, and the one record of each goal, are in goalwire.rules.goals.client; the requests in requests.py.
Replies complete futures on the thread that brings them, so that no executor is needed to wait. The acceptance
of a goal whose server runs in the client's own executor waits for its turn there instead: see acceptances.py.
Feedback and statuses go through the executor, in the client's group: see client_streams.py.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any, cast

from goalwire.cdr import codec
from goalwire.entities.actions.acceptances import Acceptances
from goalwire.entities.actions.blocking_calls import BlockingCalls
from goalwire.entities.actions.client_goal_handle import ClientGoalHandle, ResultFuture
from goalwire.entities.actions.client_requests import LATE_S, ActionRequests, CancelCall, GoalCall
from goalwire.entities.actions.client_results import GoalResults
from goalwire.entities.actions.client_streams import ClientStreams
from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.entities.actions.types import goal_id_bytes
from goalwire.entities.call_deadlines import CallContext, TimedCalls
from goalwire.entities.graph_waiting import (
    ServerWait,
    ServerWaitQueue,
)
from goalwire.entities.message_type_errors import explain_wrong_message
from goalwire.entities.node import NodeCore
from goalwire.entities.pending_call import PENDING_LIMIT, unanswered
from goalwire.entities.type_support import ActionSupport
from goalwire.errors import (
    ClosedError,
    InvalidHandle,
    TooManyCallsError,
)
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import EventQueue, ResponseTicks
from goalwire.execution.future import Future
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.rules.goals import effects as effect
from goalwire.rules.goals import wire
from goalwire.rules.goals.client import ClientGoal, GoalClient
from goalwire.rules.goals.ids import GoalId, new_goal_id
from goalwire.transport.contract import Payload, Sample

if TYPE_CHECKING:
    from goalwire.rules.goals.client import FeedbackQueue
    from goalwire.rules.statistics import ActionClientStatistics

    Effects = list[effect.ClientEffect[ResultFuture, Payload]]


class ActionClientCore(TimedCalls):
    """One action client: three clients, for goals, cancelling and results, and two subscriptions.

    Its `call_timeout` limits the time until a goal's acceptance, not the goal's execution.
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
        """The reactor: the rules, and the record of each goal."""
        self.blocking = BlockingCalls(self)
        self.lock = Lock()
        """Guards `goals`: the rules take no lock themselves."""
        self.logger: RcutilsLogger = get_logger(node.logger_name).get_child('action_client')
        self._clock = node.context.shutdown_signal.clock
        self.goal_type: type = support.cls.Goal  # type: ignore[attr-defined]
        """The action's Goal class."""
        self._encode_goal = codec.encoder(self.goal_type)
        self._wait_queue: ServerWaitQueue | None = None
        self.arrivals = ResponseTicks(node.work_queue, self)
        self._names = node.resolve_action(name)
        self._server_wait = ServerWait(node, 'action', self.full_name, self.server_is_there)
        self.acceptances = Acceptances(node, self._names.send_goal, self.blocking.futures)
        take_statuses = partial(self.dispatch, self.goals.on_status)
        self.streams = ClientStreams(self, support, group, self.goals, take_statuses)
        with ExitStack() as undo:
            self._open(undo, support, qos)
            undo.pop_all()
        node.own(self)

    def _open(self, undo: ExitStack, support: ActionSupport, qos: ActionQoS) -> None:
        """Declare the clients and subscriptions. If one of them fails, `undo` takes back the earlier ones."""
        names = self._names
        self.goal_requests = ActionRequests(self, 'goal', names.send_goal, support.send_goal, qos.goal)
        undo.callback(self.goal_requests.close)
        self.result_requests = ActionRequests(
            self, 'result', names.get_result, support.get_result, qos.result
        )
        undo.callback(self.result_requests.close)
        self.results = GoalResults(self, self.result_requests)
        self.cancel_requests = ActionRequests(
            self, 'cancel request', names.cancel_goal, support.cancel_goal, qos.cancel
        )
        undo.callback(self.cancel_requests.close)
        self._requests = (self.goal_requests, self.result_requests, self.cancel_requests)
        undo.callback(self.streams.close)
        self.streams.open(names, qos)

    # -- the rules, and what they decide -------------------------------------------------------------------

    def dispatch(self, event: Callable[..., Effects], *args: Any) -> None:
        """Pass an event to the reactor and perform its effects."""
        with self.lock:
            effects = event(*args)
        for item in effects:
            match item:
                case effect.StatusChanged(goal_id, _):
                    goal = self.goals.active.get(goal_id) or self.goals.ended.get(goal_id)
                    if goal is not None and goal.heard is not None:
                        goal.heard()
                case effect.RequestResult(goal_id):
                    self.results.request(goal_id)
                case effect.DeliverResult(future, _, payload):
                    self.results.deliver(future, payload)
                case effect.FailResult(future, error):
                    self.results.fail(future, error)

    def goal(self, goal_id: GoalId) -> ClientGoal[ResultFuture]:
        """Return the record of a goal; if there is none, a new record with the status UNKNOWN."""
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
        feedback = None if feedback_callback is None else self.streams.make_feedback_queue(feedback_callback)
        return self.send_as(goal_id, goal, feedback)

    def send_as(
        self,
        goal_id: GoalId,
        goal: Any,
        feedback: FeedbackQueue | None,
        call_context: CallContext | None = None,
        *,
        keep: bool = False,
    ) -> Future[ClientGoalHandle[Any, Any, Any]]:
        """Send a goal; its feedback goes to the queue, still serialized. Raises as `send` does.

        With a context, or a `default_timeout`, the future ends with a typed error if nobody answers, and a
        goal that is accepted too late is cancelled, unless `keep` is set.
        """
        if not isinstance(goal, self.goal_type):
            raise TypeError(explain_wrong_message(self.goal_type, goal))
        if self.destroyed:
            raise InvalidHandle
        self._make_room()
        payload = wire.wrap(goal_id, self._encode_goal(goal))
        with self.lock:
            record = self.goals.on_send(goal_id, feedback, self._clock.system_now())

        def decode(raw: Payload) -> ClientGoalHandle[Any, Any, Any]:
            return ClientGoalHandle(self, record, self.support.send_goal.decode_response(raw))

        call = GoalCall(self.goal_requests, record, decode, keep=keep)
        try:
            self.goal_requests.start(call, payload, call_context or self._new_context())
        except BaseException:
            self.discard_goal(record, '')
            raise
        return call

    def _make_room(self) -> None:
        """If there are too many goals, drop one that can be spared. Raises TooManyCallsError if none can."""
        self.goal_requests.check_room()
        if len(self.goals.active) < PENDING_LIMIT:
            return
        with self.lock:
            is_room = self.goals.on_crowd()
        if not is_room:
            raise TooManyCallsError(
                f"cannot send a goal to '{self.full_name}': {PENDING_LIMIT} goals of this client are "
                'under way already; wait for the results of some of them first'
            )

    def _new_context(self, timeout: float | None = None) -> CallContext | None:
        """The context of a request that may take `timeout` or `default_timeout` s; None if both are None."""
        limit = self.default_timeout if timeout is None else timeout
        return None if limit is None else CallContext(self.node.context, 'action', self.full_name, limit)

    def make_wait_queue(self) -> ServerWaitQueue:
        """Return the queue in which the requests of this client wait for a server."""
        if self._wait_queue is None:
            self._wait_queue = ServerWaitQueue(self.node.context, self.server_is_there, self.goal_service)
        return self._wait_queue

    def on_goal_reply(self, call: GoalCall, sample: Sample) -> None:
        """Take a server's answer to a goal: accepted or refused."""
        goal, payload = call.goal, sample.payload
        with self.lock:
            (answer,) = self.goals.on_goal_reply(goal.goal_id, wire.is_acceptance(payload))
        if isinstance(answer, effect.UnexpectedReply):
            self.logger.warning(
                'Ignoring unexpected goal response. There may be more than one action server '
                f"for the action '{self.name}'"
            )
            return
        self.goal_requests.latencies.add(sample.received_timestamp - goal.sent_at)
        self.acceptances.take(call, payload)

    def discard_goal(self, goal: ClientGoal[ResultFuture], reason: str) -> None:
        """Drop the record of a goal that no server has accepted."""
        self.dispatch(self.goals.on_send_failed, goal.goal_id, unanswered('goal', reason))

    def cancel_sending(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Stop waiting for a server to accept a goal. If one still accepts it, the goal is cancelled."""
        if isinstance(sending, GoalCall):
            sending.cancel_goal()

    # -- goals that were sent before -----------------------------------------------------------------------

    def follow(self, goal_id: GoalId, feedback: FeedbackQueue) -> ClientGoal[ResultFuture]:
        """Keep a record of a goal that any client has sent before; the goal's feedback goes to the queue.

        Raises GoalIdTaken if this client follows it already, InvalidHandle once destroyed.
        """
        if self.destroyed:
            raise InvalidHandle
        with self.lock:
            record = self.goals.on_follow(goal_id, feedback)
        if self.streams.latest_statuses:
            self.dispatch(self.goals.on_status, self.streams.latest_statuses)
        return record

    # -- results -------------------------------------------------------------------------------------------

    def get_result(self, goal_id: GoalId, call_context: CallContext | None = None) -> Future[Any]:
        """Ask for a goal's result; the future gives the action's GetResult response."""
        if self.destroyed:
            raise InvalidHandle
        return self.results.ask(goal_id, call_context)

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """Log why a goal was aborted: programs for rclpy cannot show the reason, since rclpy has none."""
        self.logger.warning(f"Action '{self.name}': goal {goal_id.hex()} was aborted: {reason}")

    # -- cancelling ----------------------------------------------------------------------------------------

    def cancel_goal(
        self, goal_id: GoalId, stamp_ns: int = 0, call_context: CallContext | None = None, asked_at: str = ''
    ) -> Future[Any]:
        """Ask for cancellation; the future gives an action_msgs/srv/CancelGoal response.

        `asked_at` is the line of the program that a warning names if the program does not read a refusal.
        """
        if self.destroyed:
            raise InvalidHandle
        call = CancelCall(self.cancel_requests, self.support.cancel_goal.decode_response, asked_at)
        payload = wire.encode_cancel_request(goal_id, stamp_ns)
        self.cancel_requests.start(call, payload, call_context or self._new_context())
        return call

    def cancel_quietly(self, goal_id: GoalId) -> None:
        """Ask for cancellation, and ignore the server's answer."""
        with suppress(ClosedError):
            asked = self.cancel_goal(goal_id, call_context=self._new_context(LATE_S))
            asked.add_waker(lambda: cast('None', asked.exception()))  # read the error, or a warning follows

    # -- waiting -------------------------------------------------------------------------------------------

    def server_is_there(self) -> bool:
        """True while the graph shows all five parts of a server; False once this client is destroyed.

        Raises ShutDownError after the context's end.
        """
        if self.destroyed:
            return False
        self.node.check_open()
        if not self.node.graph.has_action(self._names.name, self.type_name):
            return False
        return all(each.reaches_server() for each in self._requests)

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until there is a server (True) or the timeout (False); None waits without limit."""
        return self._server_wait.wait(timeout_sec)

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
        """The action's type, as 'pkg/action/Name'."""
        return self.support.send_goal.type_name.removesuffix('_SendGoal')

    def event_queues(self) -> list[EventQueue[Any]]:
        """The queues in which statuses and the feedback of each goal wait for the executor."""
        queues = self.goals.feedback_queues()
        return [self.streams.statuses, *(queue for queue in queues if isinstance(queue, EventQueue))]

    def statistics(self) -> ActionClientStatistics:
        """Return the counts of goals and feedback messages."""
        from goalwire.rules.statistics import ActionClientStatistics

        with self.lock:
            counted, dropped = self.goals.statistics(), self.goals.feedback_dropped
        return ActionClientStatistics(
            self.full_name,
            counted,
            self.streams.feedback,
            dropped,
            self.goal_requests.latencies.histogram(),
            self.results.latencies.histogram(),
            self.streams.rejected,
        )

    # -- the end -------------------------------------------------------------------------------------------

    def destroy(self) -> None:
        """Undeclare. Pending futures stay pending, as in ROS 2; those with a timeout fail. Idempotent."""
        if self.destroyed:
            return
        self.destroyed = True
        self.node.disown(self)
        self.streams.close()
        for requests in self._requests:
            requests.close()
        self.blocking.end()
        queues = self.goals.feedback_queues()
        self.dispatch(self.goals.on_close, InvalidHandle())
        for queue in queues:
            queue.close()
