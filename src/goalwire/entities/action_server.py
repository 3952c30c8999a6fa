"""An action server: feeds its reactor with what arrives, performs what the reactor decides.

The rules are in goalwire.protocol.goals.server. Effects on the wire are performed in the reactor's order, by
one thread at a time and under no lock; the user's callbacks run on the executor, in the server's group, and
hold nothing up.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from threading import Lock
from types import CoroutineType
from typing import Any

from goalwire.codec import cdr
from goalwire.entities.exceptions import InvalidHandle, RCLError, ShutDownError
from goalwire.entities.goal_handle import ServerGoalHandle
from goalwire.entities.node import NodeCore
from goalwire.entities.request_server import RequestServer
from goalwire.entities.type_support import ActionSupport, MessageSupport
from goalwire.errors import ClosedError
from goalwire.execution.agenda import Alarm
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.execution.work import Work
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.protocol.goals import effects as effect
from goalwire.protocol.goals import wire
from goalwire.protocol.goals.ids import GoalId
from goalwire.protocol.goals.server import RESULT_TIMEOUT_NS, GoalServer
from goalwire.protocol.goals.table import GoalEvent, GoalStatus, InvalidTransition
from goalwire.protocol.qos import ACTION_STATUS_DEFAULT, DEFAULT, SERVICES_DEFAULT, QoS
from goalwire.transport.contract import Endpoint, EndpointKind, Payload, PublisherPort, Request

Effects = list[effect.ServerEffect[Request, Any]]


class GoalResponse(Enum):
    """What a goal callback returns."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """What a cancel callback returns."""

    REJECT = 1
    ACCEPT = 2


@dataclass(frozen=True, slots=True)
class ActionQoS:
    """The QoS of an action's three services and two topics."""

    goal: QoS = SERVICES_DEFAULT
    result: QoS = SERVICES_DEFAULT
    cancel: QoS = SERVICES_DEFAULT
    feedback: QoS = DEFAULT
    status: QoS = ACTION_STATUS_DEFAULT


@dataclass(slots=True)
class ActionCallbacks:
    """What the user supplies; each may be `async def`."""

    execute: Callable[[ServerGoalHandle], Any]
    goal: Callable[[Any], Any]
    accepted: Callable[[ServerGoalHandle], Any]
    cancel: Callable[[ServerGoalHandle], Any]


class ActionServerCore:
    """One action server. `result_timeout_ns` as in GoalServer."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        callbacks: ActionCallbacks,
        group: CallbackGroup,
        qos: ActionQoS | None = None,
        result_timeout_ns: int = RESULT_TIMEOUT_NS,
    ) -> None:
        self.node = node
        self.support = support
        self.name = name
        self.callbacks = callbacks
        qos = qos or ActionQoS()
        self._logger: RcutilsLogger = get_logger(node.logger_name).get_child('action_server')
        self._lock = Lock()
        self._reactor: GoalServer[Request, Any] = GoalServer(result_timeout_ns)
        self._outbox: deque[effect.ServerEffect[Request, Any]] = deque()
        self._performing = Lock()
        self._handles: dict[GoalId, ServerGoalHandle] = {}
        self._alarm = Alarm(self._on_time)
        self._result_class = support.cls.Result  # type: ignore[attr-defined]
        self._feedback_class = support.cls.Feedback  # type: ignore[attr-defined]
        self._decode_goal = cdr.decoder(support.cls.Goal)  # type: ignore[attr-defined]
        self._encode_feedback = cdr.encoder(self._feedback_class)
        names = node.resolve_action(name)
        self._feedback = self._publisher(names.feedback, support.feedback, qos.feedback, waits_for_room=True)
        self._status = self._publisher(names.status, support.status, qos.status)
        self._result_server = RequestServer(
            node,
            support.get_result,
            names.get_result,
            self._on_result,
            qos.result,
            group,
            decode=wire.goal_id_of,
        )
        self._servers = (
            RequestServer(
                node,
                support.send_goal,
                names.send_goal,
                self._on_goal,
                qos.goal,
                group,
                decode=self._split_goal,
            ),
            self._result_server,
            RequestServer(
                node,
                support.cancel_goal,
                names.cancel_goal,
                self._on_cancel,
                qos.cancel,
                group,
                decode=wire.decode_cancel_request,
            ),
        )
        self._destroyed = False
        node.own(self)

    def _publisher(
        self, name: str, support: MessageSupport, qos: QoS, *, waits_for_room: bool = False
    ) -> PublisherPort:
        return self.node.port.publisher(
            Endpoint(
                EndpointKind.PUBLISHER,
                name,
                support.type_name,
                support.type_hash,
                qos,
                support.has_buffers,
                waits_for_room=waits_for_room,
            )
        )

    def _split_goal(self, payload: Payload) -> tuple[GoalId, Any]:
        goal_id, goal = wire.unwrap(bytes(payload))
        return goal_id, self._decode_goal(goal)

    # -- the reactor, and what it decides ------------------------------------------------------------------

    def _react(self, event: Callable[..., Effects], *args: Any) -> Effects:
        """Feed the reactor, perform its effects on the wire, return those that call the user."""
        with self._lock:
            effects = event(*args)
            self._outbox.extend(item for item in effects if not isinstance(item, _USERS))
        self._perform()
        return [item for item in effects if isinstance(item, _USERS)]

    def _perform(self) -> None:
        while self._outbox:
            if not self._performing.acquire(blocking=False):
                return  # that thread looks again
            try:
                while self._outbox:
                    with suppress(ClosedError):  # the context has ended: there is nobody to tell
                        self._perform_one(self._outbox.popleft())
            finally:
                self._performing.release()

    def _perform_one(self, item: effect.ServerEffect[Request, Any]) -> None:
        match item:
            case effect.PublishStatus():
                with self._lock:
                    payload = self._reactor.take_status()
                if payload is not None:
                    self._status.publish(payload)
            case effect.ReplyGoal(request, accepted, stamp_ns):
                request.reply(wire.encode_acceptance(accepted, stamp_ns))
            case effect.ReplyCancel(request, code, goals):
                request.reply(wire.encode_cancel_reply(code, goals))
            case effect.ReplyResult(request, status, result):
                payload = result if isinstance(result, bytes) else self._encode_result(status, result)
                request.reply(payload)
            case effect.WakeAt(time_ns):
                self.node.home.set_alarm(self._alarm, time_ns)
            case effect.AssumedAborted(goal_id):
                ints = list(goal_id)
                self._logger.warning(f'Goal state not set, assuming aborted. Goal ID: {ints}')

    def _now(self) -> int:
        return self.node.context.lifeline.clock.now()

    def _on_time(self) -> None:
        self._react(self._reactor.on_time, self._now())

    # -- goals ---------------------------------------------------------------------------------------------

    def _on_goal(self, request: Request, message: tuple[GoalId, Any]) -> object:
        goal_id, goal = message
        if not self._react(self._reactor.on_goal_request, goal_id, request, self._now()):
            return None
        try:
            decision = self.callbacks.goal(goal)
        except BaseException:
            self._decide(goal_id, goal, GoalResponse.REJECT)
            raise
        if isinstance(decision, CoroutineType):
            return self._decide_later(goal_id, goal, decision)
        return self._decide(goal_id, goal, decision)

    async def _decide_later(self, goal_id: GoalId, goal: Any, decision: Coroutine[Any, Any, Any]) -> None:
        try:
            response = await decision
        except BaseException:
            self._decide(goal_id, goal, GoalResponse.REJECT)
            raise
        outcome = self._decide(goal_id, goal, response)
        if isinstance(outcome, CoroutineType):
            await outcome

    def _decide(self, goal_id: GoalId, goal: Any, response: object) -> object:
        if not isinstance(response, GoalResponse):
            self._logger.warning('Goal request callback did not return a GoalResponse type. Rejecting goal.')
        accepted = response is GoalResponse.ACCEPT
        handle = ServerGoalHandle(self, goal_id, goal)
        if accepted:
            self._handles[goal_id] = handle
        stamp_ns = self.node.context.lifeline.clock.system_now()
        if not self._react(self._reactor.on_goal_decision, goal_id, accepted, stamp_ns):
            self._handles.pop(goal_id, None)
            return None
        return self.callbacks.accepted(handle)

    # -- execution -----------------------------------------------------------------------------------------

    def goal_status(self, goal_id: GoalId) -> GoalStatus:
        """Return where a goal stands."""
        return self._reactor.status(goal_id)

    def execute(self, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any] | None) -> None:
        """Start a goal's execution; raises RCLError where its state does not allow that."""
        with _rcl_errors():
            started = self._react(self._reactor.on_execute, handle.goal_id_bytes)
        if started:
            self.node.home.post(_Execution(self, handle, callback or self.callbacks.execute))

    def end(self, handle: ServerGoalHandle, event: GoalEvent) -> None:
        """End a goal; raises RCLError where its state does not allow that."""
        with _rcl_errors():
            self._react(self._reactor.on_event, handle.goal_id_bytes, event, self._now())
        self._handles.pop(handle.goal_id_bytes, None)

    def publish_feedback(self, handle: ServerGoalHandle, feedback: Any) -> None:
        """Send a goal's feedback; raises TypeError for another type, InvalidHandle once destroyed."""
        if not isinstance(feedback, self._feedback_class):
            raise TypeError(f'Expected {self._feedback_class}, got {type(feedback)}')
        if self._destroyed:
            raise InvalidHandle
        payload = wire.wrap(handle.goal_id_bytes, self._encode_feedback(feedback))
        try:
            self._feedback.publish(payload)
        except ClosedError:
            raise ShutDownError(f"cannot publish feedback of the action '{self.name}'") from None

    def finished(self, handle: ServerGoalHandle, result: object) -> None:
        """Execution is over. A result that cannot be sent is logged, and the default one sent instead."""
        status = handle.status if not handle.is_active else GoalStatus.ABORTED
        payload = self._checked_result(GoalStatus(status), result)
        self._react(self._reactor.on_result, handle.goal_id_bytes, payload, self._now())
        self._handles.pop(handle.goal_id_bytes, None)

    def _checked_result(self, status: GoalStatus, result: object) -> bytes | None:
        if isinstance(result, self._result_class):
            try:
                return self._encode_result(status, result)
            except (TypeError, ValueError) as error:
                self._logger.error(f'Result cannot be sent, an empty one is: {error}')
        elif result is not _FAILED:
            name = self._result_class.__name__
            self._logger.error(
                f"Action '{self.name}': the execute callback returned {type(result).__name__}; "
                f'an empty result is sent; return a {name}'
            )
        return None

    def _encode_result(self, status: GoalStatus, result: Any) -> bytes:
        support = self.support.get_result
        response: Any = support.response
        return support.encode_response(response(status=int(status), result=result or self._result_class()))

    def report_failure(self, error: BaseException) -> None:
        """Log what an execute callback raised, with its traceback."""
        import traceback

        lines = ''.join(traceback.format_exception(error)).rstrip()
        self._logger.error(f'Error raised in execute callback: {error}\n{lines}')

    # -- results and cancelling ----------------------------------------------------------------------------

    def _on_result(self, request: Request, goal_id: GoalId) -> None:
        self._react(self._reactor.on_result_request, goal_id, request, self._now())

    def _on_cancel(self, request: Request, message: tuple[GoalId, int]) -> Coroutine[Any, Any, None] | None:
        goal_id, stamp_ns = message
        asked = self._react(self._reactor.on_cancel_request, goal_id, stamp_ns, request, self._now())
        pending: list[tuple[effect.AskCancel, Coroutine[Any, Any, Any]]] = []
        failures: list[BaseException] = []
        for ask in asked:
            assert isinstance(ask, effect.AskCancel)
            answer = self._ask_cancel(ask.goal_id, failures)
            if isinstance(answer, CoroutineType):
                pending.append((ask, answer))
            else:
                self._decide_cancel(ask, answer)
        if pending:
            return self._decide_cancels_later(pending, failures)
        if failures:
            raise failures[0]
        return None

    def _ask_cancel(self, goal_id: GoalId, failures: list[BaseException]) -> object:
        handle = self._handles.get(goal_id)
        if handle is None:
            return CancelResponse.REJECT
        try:
            return self.callbacks.cancel(handle)
        except BaseException as error:
            failures.append(error)
            return CancelResponse.REJECT

    def _decide_cancel(self, ask: effect.AskCancel, answer: object) -> None:
        accepted = answer is CancelResponse.ACCEPT
        self._react(self._reactor.on_cancel_decision, ask.cancellation, ask.goal_id, accepted)

    async def _decide_cancels_later(
        self, pending: list[tuple[effect.AskCancel, Coroutine[Any, Any, Any]]], failures: list[BaseException]
    ) -> None:
        for ask, coroutine in pending:
            answer: object = CancelResponse.REJECT
            try:
                answer = await coroutine
            except BaseException as error:
                failures.append(error)
            self._decide_cancel(ask, answer)
        if failures:
            raise failures[0]

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
        self.node.home.drop_alarm(self._alarm)
        self._result_server.work_off()
        self._react(self._reactor.on_close)
        for server in self._servers:
            server.destroy()
        self._feedback.close()
        self._status.close()
        self._handles.clear()


_USERS = (effect.AskGoal, effect.Accepted, effect.Execute, effect.AskCancel)
_FAILED = object()


class _rcl_errors:  # noqa: N801 - read as a word in `with _rcl_errors()`
    """Turns InvalidTransition into the RCLError that rclpy raises, with the same text."""

    def __enter__(self) -> None: ...

    def __exit__(self, _type: object, error: BaseException | None, _traceback: object) -> None:
        if isinstance(error, InvalidTransition):
            raise RCLError(str(error)) from None


class _Execution(Work):
    """One run of an execute callback, in no callback group, as in rclpy."""

    __slots__ = ('_callback', '_handle', '_server')

    def __init__(
        self, server: ActionServerCore, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any]
    ) -> None:
        super().__init__(server.node.home, None)
        self._server = server
        self._handle = handle
        self._callback = callback

    def run(self) -> object:
        if self._server.destroyed:
            return None
        try:
            result = self._callback(self._handle)
        except BaseException as error:
            self._failed(error)
            return None
        if isinstance(result, CoroutineType):
            return self._carry(result)
        self._server.finished(self._handle, result)
        return None

    async def _carry(self, coroutine: Coroutine[Any, Any, Any]) -> None:
        from asyncio import CancelledError

        try:
            result = await coroutine
        except CancelledError:  # the executor was shut down
            self._server.finished(self._handle, _FAILED)
            raise
        except BaseException as error:
            self._failed(error)
        else:
            self._server.finished(self._handle, result)

    def _failed(self, error: BaseException) -> None:
        self._server.report_failure(error)
        self._server.finished(self._handle, _FAILED)
        if not isinstance(error, Exception):
            raise error
