"""An action server: tells its reactor what arrives, and performs the effects that the reactor decides.

The rules, and the one record of each goal, are in goalwire.rules.goals.server. Effects on the wire are
performed in the reactor's order, by one thread at a time and under no lock. The user's callbacks run on the
executor, in the server's group, and delay no effect. endpoints.py has the services and topics,
server_goal_handle.py the goal handles.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING, Any

from goalwire.cdr import codec
from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.entities.actions.endpoints import ActionQoS, ActionServerEndpoints
from goalwire.entities.actions.lost_clients import ClientWatch
from goalwire.entities.actions.server_decisions import ServerDecisions
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    Execution,
    Failure,
    ServerGoalHandle,
)
from goalwire.entities.actions.server_results import ServerResults
from goalwire.entities.message_type_errors import explain_wrong_message
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ActionSupport
from goalwire.errors import (
    ClosedError,
    InvalidTransition,
    RCLError,
    TransportError,
)
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.event_queue import CallSoon, EventQueue
from goalwire.execution.time.clock import ClockTimerEntry
from goalwire.execution.weak_methods import weakly
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.rules.goals import effects as effect
from goalwire.rules.goals import wire
from goalwire.rules.goals.goal_book import ServerGoal
from goalwire.rules.goals.ids import GoalId
from goalwire.rules.goals.server import GoalServer
from goalwire.rules.goals.states import GoalEvent, GoalStatus
from goalwire.rules.latencies import Latencies
from goalwire.rules.reasons import describe_error
from goalwire.transport.contract import Payload, Request

if TYPE_CHECKING:
    from goalwire.entities.actions.advice import ActionAdvice
    from goalwire.rules.statistics import ActionServerStatistics

Effects = effect.ServerEffects[Request, bytes]
_USERS = (effect.AskGoal, effect.Accepted, effect.AskCancel, effect.StoppedByServer)
"""Effects that call the program: the method that feeds the reactor performs these itself."""


class ActionServerCore:
    """One action server. The `reactor` keeps the records of its goals, and decides about each event."""

    advice: ActionAdvice | None = None
    """Logs mistakes in the program's callbacks. An API whose callbacks can make some sets it before
    `__init__`.
    """

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        callbacks: ActionCallbacks,
        group: CallbackGroup,
        qos: ActionQoS | None = None,
        reactor: GoalServer[Request, bytes] | None = None,
    ) -> None:
        self.node = node
        self.support = support
        self.name = name
        self.callbacks = callbacks
        self.logger: RcutilsLogger = get_logger(node.logger_name).get_child('action_server')
        self.reactor: GoalServer[Request, bytes] = reactor or GoalServer()
        self.now = node.clock.now_ns
        """The time of the node's clock in ns, as rcl's action servers take it."""
        self._lock = Lock()
        self._dispatcher: OrderedDispatcher[effect.ServerEffect[Request, bytes]] = OrderedDispatcher(
            self._perform
        )
        self._alarm = ClockTimerEntry(node.work_queue, node.clock, weakly(self._expire_later))
        self._alarm.follow()
        self.destroyed = False
        self._feedback_class = support.cls.Feedback  # type: ignore[attr-defined]
        self._decode_goal = codec.decoder(support.cls.Goal)  # type: ignore[attr-defined]
        self._encode_feedback = codec.encoder(self._feedback_class)
        self.failed = 0
        """How many executions of goals raised an error."""
        self.leaves_goals = False
        """True if the goals go on when the server is destroyed, so that nobody may hear that they ended."""
        self._feedback = 0
        self.durations = Latencies()
        """How long execute callbacks took."""
        self.steady_clock = node.context.shutdown_signal.clock
        self.clients: ClientWatch | None = None
        """Watches for clients that go; None if their goals go on all the same."""
        self._decisions = ServerDecisions(self)
        self.results = ServerResults(name, support, self.logger, self.reactor.journal)
        try:
            self._open(qos or ActionQoS(), group)
        except BaseException:
            self.results.close()
            raise

    def _open(self, qos: ActionQoS, group: CallbackGroup) -> None:
        """Declare the endpoints: goals may arrive, and run on another thread, before this method returns."""
        node = self.node
        names = node.resolve_action(self.name)
        self._endpoints = ActionServerEndpoints(node, self.support, names, qos, group)
        if self.reactor.watches_clients:
            grace_ns = self.reactor.client_grace_ns
            self.clients = ClientWatch(node, names, grace_ns, self._unfollow, self.end_goals_of)
        try:
            self._endpoints.open(
                self._decisions.on_goal, self._on_result, self._decisions.on_cancel, self._split_goal
            )
        except BaseException:
            if self.clients is not None:
                self.clients.close()
            raise
        for server in self._endpoints.servers:
            server.entity = self
        if self.clients is not None:
            node.remains.add(self.clients.close)
        node.own(self)

    def _split_goal(self, payload: Payload) -> tuple[GoalId, Any]:
        goal_id, goal = wire.unwrap(bytes(payload))
        return goal_id, self._decode_goal(goal)

    # -- the reactor, and what it decides ------------------------------------------------------------------

    def dispatch(self, event: Callable[..., Effects], *args: Any) -> Effects:
        """Feed the reactor, perform its effects on the wire, return the effects that call the program."""
        asked: Effects = []
        is_posted = False
        with self._lock:
            for item in event(*args):
                if isinstance(item, _USERS):
                    asked.append(item)
                else:
                    self._dispatcher.post(item)
                    is_posted = True
        if is_posted:
            self._dispatcher.drain()
        return asked

    def _perform(self, item: effect.ServerEffect[Request, bytes]) -> None:
        """Perform one effect. If it fails, the next effects, and the event that caused it, still go on."""
        try:
            match item:
                case effect.PublishStatus():
                    with self._lock:
                        payload = self.reactor.take_status()
                    if payload is not None:
                        self._endpoints.status.publish(payload)
                case effect.ReplyGoal(request, accepted, stamp_ns):
                    request.reply(wire.encode_acceptance(accepted, stamp_ns))
                case effect.ReplyCancel(request, code, goals):
                    request.reply(wire.encode_cancel_reply(code, goals))
                case effect.ReplyResult(request, status, result):
                    self.results.reply(request, status, result)
                case effect.KeepResult():
                    self.results.keep(item)
                case effect.FindResult():
                    self.results.find(item)
                case effect.Execute(_, execution):
                    if execution is not None:
                        self.node.work_queue.post_first(execution)
                case effect.WakeAt(time_ns):
                    self._alarm.set(time_ns)
                case effect.AssumedAborted():
                    pass  # `finished` logs it
        except ClosedError:
            return  # the context has ended: nothing can be sent
        except TransportError as error:
            self.logger.error(f"Action '{self.name}': {type(item).__name__} did not reach a client: {error}")

    def expire(self) -> None:
        """Discard the results that were kept for long enough."""
        if not self.destroyed:
            self.dispatch(self.reactor.on_time, self.now())

    def _on_result(self, request: Request, goal_id: GoalId) -> None:
        client = request.sample.gid
        self.dispatch(self.reactor.on_result_request, goal_id, request, self.now(), client)

    # -- what goal handles ask for -------------------------------------------------------------------------

    def goal(self, goal_id: GoalId) -> ServerGoal[Any, Any]:
        """Return the record of a goal; if there is none, a new record with the status UNKNOWN."""
        return self.reactor.goals.get(goal_id) or ServerGoal(goal_id)

    def start_execution(
        self, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any] | None
    ) -> None:
        """Have the executor execute a goal, in its turn; raises RCLError if its state does not allow that.

        If neither the goal nor the server has an execute callback, the program executes the goal itself.
        """
        callback = callback or self.callbacks.execute
        self._start(handle, None if callback is None else Execution(self, handle, callback))

    def begin_execution(self, handle: ServerGoalHandle) -> None:
        """Note that the program executes a goal itself; raises RCLError as `start_execution` does."""
        self._start(handle, None)

    def _start(self, handle: ServerGoalHandle, execution: Execution | None) -> None:
        try:
            effects = self.dispatch(self.reactor.on_execute, handle.goal_id_bytes, self.now(), execution)
        except InvalidTransition as error:
            raise RCLError(str(error)) from None
        if effects:
            self._tell_stopped(effects)

    def publish_feedback(self, handle: ServerGoalHandle, feedback: Any) -> None:
        """Send a goal's feedback; raises TypeError for another type.

        Once the server is destroyed nothing is sent: an execute callback may outlive its server.
        """
        if not isinstance(feedback, self._feedback_class):
            raise TypeError(explain_wrong_message(self._feedback_class, feedback))
        if self.destroyed:
            return
        payload = wire.wrap(handle.goal_id_bytes, self._encode_feedback(feedback))
        self._feedback += 1
        try:
            self._endpoints.feedback.publish(payload)
        except ClosedError:
            what = f"cannot publish feedback of the action '{self.name}'"
            raise self.node.context.shutdown_signal.end_error(what) from None

    def end(self, handle: ServerGoalHandle, event: GoalEvent) -> None:
        """End a goal; raises RCLError if its state does not allow that."""
        try:
            self.dispatch(self.reactor.on_event, handle.goal_id_bytes, event, self.now())
        except InvalidTransition as error:
            refused = RCLError(str(error))  # rclpy raises RCLError, with this text
            if not GoalStatus(error.status).is_active:
                refused.add_note('the goal has ended already: call succeed(), abort() or canceled() once')
            elif event is GoalEvent.CANCELED:
                refused.add_note("call canceled() only behind 'if goal_handle.is_cancel_requested:'")
            raise refused from None

    def finished(self, handle: ServerGoalHandle, outcome: object) -> None:
        """Take the outcome of a goal's execution.

        If its result cannot be sent, that is logged, and an empty result is sent.
        """
        if isinstance(outcome, Failure):
            result = None
            if outcome.result is not None:
                result = self._encode(outcome.result, 'the failure came with')
            if outcome.reason:
                result = wire.with_reason(result or self.results.default(), outcome.reason)
        else:
            result = self._encode(outcome, 'the execute callback returned')
        if self.advice is not None and not self.destroyed:
            self.advice.on_end(handle, self.callbacks, outcome)
        self.dispatch(self.reactor.on_result, handle.goal_id_bytes, result, self.now())

    def failure(self, handle: ServerGoalHandle, error: Exception) -> Failure:
        """Call the program's on_failure with the error that execute raised; return the outcome for the
        client.
        """
        self.failed += 1
        result: object = None
        if self.callbacks.failed is not None:
            try:
                result = self.callbacks.failed(handle, error)
            except Exception as another:
                self.logger.error(
                    f"Action '{self.name}': on_failure failed itself: {describe_error(another)}"
                )
        return Failure(result, describe_error(error))

    def _encode(self, result: object, told: str) -> bytes | None:
        return self.results.encode(result, told, self.callbacks.execute)

    # -- what the server does on its own -------------------------------------------------------------------

    def _expire_later(self) -> None:
        self._later(self.expire)

    def _later(self, call: Callable[[], object]) -> None:
        """Have the executor call a function."""
        self.node.work_queue.post(CallSoon(self.node.work_queue, call))

    def _tell_stopped(self, effects: Effects) -> None:
        """Call the program's `stopped_by_server` with goals that a policy has cancelled or aborted."""
        for item in effects:
            if isinstance(item, effect.StoppedByServer) and self.callbacks.stopped_by_server is not None:
                goal = self.reactor.goals.get(item.goal_id)
                if goal is not None and goal.handle is not None:  # else the goal has ended meanwhile
                    self.callbacks.stopped_by_server(goal.handle)

    def _unfollow(self, client: bytes) -> None:
        with self._lock:
            self.reactor.on_client_gone(client)

    def end_goals_of(self, client: bytes) -> None:
        """Refuse, cancel or abort the goals of a client that has gone."""
        if not self.destroyed:
            self._tell_stopped(self.dispatch(self.reactor.on_client_lost, client, self.now()))

    def event_queues(self) -> list[EventQueue[Any]]:
        """The queues in which requests wait for the executor."""
        return [server.event_queue for server in self._endpoints.servers]

    def statistics(self) -> ActionServerStatistics:
        """Return the counts of goals, requests and feedback messages."""
        from goalwire.rules.statistics import ActionServerStatistics

        servers = self._endpoints.servers
        with self._lock:
            goals = self.reactor.statistics()
        return ActionServerStatistics(
            self._endpoints.names.name,
            goals,
            self._feedback,
            self.failed,
            sum(len(server.event_queue) for server in servers),
            sum(server.refused for server in servers),
            sum(server.rejected for server in servers),
            self.durations.histogram(),
        )

    # -- the end -------------------------------------------------------------------------------------------

    def destroy(self) -> None:
        """Answer every open request, abort the running goals, undeclare the endpoints. Idempotent.

        With `leaves_goals` no goal is aborted, and requests for results get no answer.
        """
        if self.destroyed:
            return
        self.destroyed = True
        self.node.disown(self)
        self._alarm.cancel()
        if self.clients is not None:
            self.node.remains.discard(self.clients.close)
            self.clients.close()
        self._endpoints.take_result_requests()
        self.dispatch(self.reactor.on_close, self.leaves_goals)
        self.results.close()
        self._endpoints.close()
