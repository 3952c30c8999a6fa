"""An action server: feeds its reactor with what arrives, performs what the reactor decides.

The rules are in goalwire.rules.goals.server. Effects on the wire are performed in the reactor's order, by
one thread at a time and under no lock; the user's callbacks run on the executor, in the server's group, and
hold nothing up. What is declared: `endpoints`. Asking the user: `decisions`. Running a goal: `execution`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any

from goalwire.cdr import codec
from goalwire.entities.actions.endpoints import ActionQoS, ActionServerEndpoints
from goalwire.entities.actions.execution import Execution, Failure, Results
from goalwire.entities.actions.goal_callbacks import ActionCallbacks, GoalCallbacks
from goalwire.entities.actions.goal_handle import ServerGoalHandle
from goalwire.entities.actions.lost_clients import LostClients
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ActionSupport
from goalwire.errors import (
    ClosedError,
    InvalidHandle,
    InvalidTransition,
    RCLError,
    ShutDownError,
    TransportError,
)
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.callback_source import CallbackSource
from goalwire.execution.clock_timer_entry import ClockTimerEntry
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.node_work_queue import NodeWorkQueue
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.rules.goals import effects as effect
from goalwire.rules.goals import wire
from goalwire.rules.goals.ids import GoalId
from goalwire.rules.goals.server import GoalServer
from goalwire.rules.goals.table import GoalEvent, GoalStatus
from goalwire.rules.latencies import Latencies
from goalwire.rules.reasons import described
from goalwire.transport.contract import Payload, Request
from goalwire.transport.ordered_dispatcher import OrderedDispatcher

if TYPE_CHECKING:
    from goalwire.rules.statistics import ActionServerStatistics

Effects = list[effect.ServerEffect[Request, bytes]]
_USERS = (effect.AskGoal, effect.Accepted, effect.AskCancel, effect.CalledOff)
"""The effects that call the user: whoever feeds the reactor performs these itself."""


class ActionServerCore:
    """One action server, by the rules of the `reactor` that it is given."""

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
        self._alarm = ClockTimerEntry(node.work_queue, node.clock, partial(self._later, self.expire))
        self._alarm.follow()
        self._destroyed = False
        self._feedback_class = support.cls.Feedback  # type: ignore[attr-defined]
        self._decode_goal = codec.decoder(support.cls.Goal)  # type: ignore[attr-defined]
        self._encode_feedback = codec.encoder(self._feedback_class)
        self._results = Results(support, name, self.logger)
        self._goal_callbacks = GoalCallbacks(self)
        self.failed = 0
        """How many goals' execution raised."""
        self._feedback = 0
        self.durations = Latencies()
        """Of execute callbacks."""
        self._executions: dict[GoalId, Execution] = {}
        """Of goals whose turn to run has not come."""
        self.steady_clock = node.context.shutdown_signal.clock
        self._lost_clients: LostClients | None = None
        self._open(qos or ActionQoS(), group)

    def _open(self, qos: ActionQoS, group: CallbackGroup) -> None:
        """Declare everything: goals may come, and run on another thread, before this returns."""
        node = self.node
        names = node.resolve_action(self.name)
        self._endpoints = ActionServerEndpoints(node, self.support, names, qos, group)
        if self.reactor.watches_clients:
            self._lost_clients = LostClients(node.graph, names.send_goal, self._on_client_lost)
        try:
            self._endpoints.open(
                self._goal_callbacks.on_goal,
                self._on_result,
                self._goal_callbacks.on_cancel,
                self._split_goal,
            )
        except BaseException:
            if self._lost_clients is not None:
                self._lost_clients.close()
            raise
        for server in self._endpoints.servers:
            server.entity = self
        node.own(self)

    def _split_goal(self, payload: Payload) -> tuple[GoalId, Any]:
        goal_id, goal = wire.unwrap(bytes(payload))
        return goal_id, self._decode_goal(goal)

    # -- the reactor, and what it decides ------------------------------------------------------------------

    def dispatch(self, event: Callable[..., Effects], *args: Any) -> Effects:
        """Feed the reactor, perform its effects on the wire, return those that call the user."""
        asked: Effects = []
        with self._lock:
            for item in event(*args):
                if isinstance(item, _USERS):
                    asked.append(item)
                else:
                    self._dispatcher.post(item)
        self._dispatcher.drain()
        return asked

    def _perform(self, item: effect.ServerEffect[Request, bytes]) -> None:
        """Perform one effect; one that fails holds up neither the next nor the event that came with it."""
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
                    request.reply(wire.with_status(result or self._results.default(), status))
                case effect.Execute(goal_id):
                    execution = self._executions.pop(goal_id, None)
                    if execution is not None:  # else the server was destroyed meanwhile
                        self.node.work_queue.post(execution)
                case effect.WakeAt(time_ns):
                    self._alarm.set(time_ns)
                case effect.AssumedAborted(goal_id):
                    ints = list(goal_id)
                    self.logger.warning(f'Goal state not set, assuming aborted. Goal ID: {ints}')
        except ClosedError:
            return  # the context has ended: there is nobody to tell
        except TransportError as error:
            self.logger.error(f"Action '{self.name}': a client was not told ({type(item).__name__}): {error}")

    def expire(self) -> None:
        """Forget the results whose time is over."""
        if not self._destroyed:
            self.dispatch(self.reactor.on_time, self.now())

    def _on_result(self, request: Request, goal_id: GoalId) -> None:
        self.dispatch(self.reactor.on_result_request, goal_id, request, self.now())

    # -- what goal handles ask for -------------------------------------------------------------------------

    def goal_status(self, goal_id: GoalId) -> GoalStatus:
        """Return where a goal stands."""
        return self.reactor.status(goal_id)

    def start_execution(
        self, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any] | None
    ) -> None:
        """Have a goal executed, in its turn; raises RCLError where its state does not allow that."""
        goal_id = handle.goal_id_bytes
        self._executions.setdefault(goal_id, Execution(self, handle, callback or self.callbacks.execute))
        try:
            effects = self.dispatch(self.reactor.on_execute, goal_id, self.now())
        except InvalidTransition as error:
            self._executions.pop(goal_id, None)
            raise RCLError(str(error)) from None
        if self.reactor.policy.preempts:
            self._cancel_quietly(effects)

    def publish_feedback(self, handle: ServerGoalHandle, feedback: Any) -> None:
        """Send a goal's feedback; raises TypeError for another type, InvalidHandle once destroyed."""
        if not isinstance(feedback, self._feedback_class):
            raise TypeError(f'Expected {self._feedback_class}, got {type(feedback)}')
        if self._destroyed:
            raise InvalidHandle
        payload = wire.wrap(handle.goal_id_bytes, self._encode_feedback(feedback))
        self._feedback += 1
        try:
            self._endpoints.feedback.publish(payload)
        except ClosedError:
            raise ShutDownError(f"cannot publish feedback of the action '{self.name}'") from None

    def end(self, handle: ServerGoalHandle, event: GoalEvent) -> None:
        """End a goal; raises RCLError where its state does not allow that."""
        try:
            self.dispatch(self.reactor.on_event, handle.goal_id_bytes, event, self.now())
        except InvalidTransition as error:
            raise RCLError(str(error)) from None  # rclpy raises that, with this text
        self._forget(handle.goal_id_bytes)

    def finished(self, handle: ServerGoalHandle, outcome: object) -> None:
        """Execution is over. A result that cannot be sent is logged, and the default one sent instead."""
        self.dispatch(self.reactor.on_result, handle.goal_id_bytes, self._results.encode(outcome), self.now())
        self._forget(handle.goal_id_bytes)

    def failure(self, handle: ServerGoalHandle, error: Exception) -> Failure:
        """Tell the program's hook what an execute callback raised; return what the client is told."""
        self.failed += 1
        result: object = None
        if self.callbacks.failed is not None:
            try:
                result = self.callbacks.failed(handle, error)
            except Exception as another:
                self.logger.error(f"Action '{self.name}': on_failure failed itself: {described(another)}")
        return Failure(result, described(error))

    def _forget(self, goal_id: GoalId) -> None:
        self._goal_callbacks.forget(goal_id)
        self._executions.pop(goal_id, None)

    def forget_ended(self, *goal_ids: GoalId) -> None:
        """Forget those of these goals that have ended without the program's doing."""
        for goal_id in goal_ids:
            if not self.reactor.status(goal_id).is_active:
                self._forget(goal_id)

    # -- what the server does on its own -------------------------------------------------------------------

    def _later(self, call: Callable[[], object]) -> None:
        """Call on the executor's thread."""
        self.node.work_queue.post(CallSoon(self.node.work_queue, call))

    def _cancel_quietly(self, effects: Effects) -> None:
        """Tell the program of goals that a policy has cancelled or aborted; forget those that have ended."""
        for item in effects:
            handle = self._goal_callbacks.handle(item.goal_id) if isinstance(item, effect.CalledOff) else None
            if handle is not None and self.callbacks.called_off is not None:
                self.callbacks.called_off(handle)
        self.forget_ended(*self._goal_callbacks.goal_ids())

    def _on_client_lost(self, client: bytes) -> None:
        self._later(partial(self.give_up, client))

    def has_lost(self, client: bytes) -> bool:
        """Return whether a client has gone, where that makes a difference."""
        return self._lost_clients is not None and client in self._lost_clients

    def give_up(self, client: bytes) -> None:
        """Refuse, cancel or abort the goals of a client that has gone."""
        if not self._destroyed:
            self._cancel_quietly(self.dispatch(self.reactor.on_client_lost, client, self.now()))

    def event_queues(self) -> list[EventQueue[Any]]:
        """Where requests wait for the executor."""
        return [server.event_queue for server in self._endpoints.servers]

    def statistics(self) -> ActionServerStatistics:
        """Count goals, requests and feedback."""
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

    @property
    def destroyed(self) -> bool:
        """True once destroyed."""
        return self._destroyed

    def destroy(self) -> None:
        """Answer every open request, abort what runs, undeclare. Idempotent."""
        if self._destroyed:
            return
        self._destroyed = True
        self.node.disown(self)
        self._alarm.drop()
        if self._lost_clients is not None:
            self._lost_clients.close()
        self._endpoints.take_result_requests()
        self.dispatch(self.reactor.on_close)
        self._endpoints.close()
        self._goal_callbacks.forget_all()
        self._executions.clear()


class CallSoon(CallbackSource):
    """One call of the server's own, on the executor's thread: what it does is published."""

    def __init__(self, work_queue: NodeWorkQueue, call: Callable[[], object]) -> None:
        super().__init__(work_queue, None)
        self._call = call

    def run(self) -> None:
        self._call()
