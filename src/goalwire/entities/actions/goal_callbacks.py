"""What the user decides about goals: taken or refused, cancelled or not; by callbacks, `async def` or not."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from enum import Enum
from types import CoroutineType
from typing import TYPE_CHECKING, Any

from goalwire.entities.actions.goal_handle import ServerGoalHandle
from goalwire.entities.enclosing import Enclosing
from goalwire.rules.goals import effects as effect

if TYPE_CHECKING:
    from goalwire.entities.actions.server import ActionServerCore
    from goalwire.rules.goals.ids import GoalId
    from goalwire.transport.contract import Request


class GoalResponse(Enum):
    """What a goal callback returns."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """What a cancel callback returns."""

    REJECT = 1
    ACCEPT = 2


@dataclass(slots=True)
class ActionCallbacks:
    """What the user supplies; the first four may be `async def`."""

    execute: Callable[[ServerGoalHandle], Any]
    goal: Callable[[Any], Any]
    accepted: Callable[[ServerGoalHandle], Any]
    cancel: Callable[[ServerGoalHandle], Any]
    failed: Callable[[ServerGoalHandle, Exception], object] | None = None
    """Gets what execute raised; may return a result to send along."""
    called_off: Callable[[ServerGoalHandle], object] | None = None
    """Gets a goal that was cancelled or aborted by the server's own policy."""


class GoalCallbacks:
    """Asks the user and tells the server's reactor. A callback that fails has refused; its error goes on."""

    def __init__(self, server: ActionServerCore) -> None:
        self._server = server
        self._handles: dict[GoalId, ServerGoalHandle] = {}

    # -- goals ---------------------------------------------------------------------------------------------

    def on_goal(self, request: Request, message: tuple[GoalId, Any]) -> object:
        """A goal has come."""
        goal_id, goal = message
        server = self._server
        client = request.sample.gid
        if not server.dispatch(server.reactor.on_goal_request, goal_id, request, server.now(), client):
            return None
        if server.has_lost(client):  # it has gone while its goal waited for the executor
            server.give_up(client)
            return None
        try:
            decision = server.callbacks.goal(goal)
        except BaseException:
            self._decide(goal_id, goal, GoalResponse.REJECT)
            raise
        if isinstance(decision, CoroutineType):
            return Enclosing(self._decide_later(goal_id, goal, decision), [decision])
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
        server = self._server
        if not isinstance(response, GoalResponse):
            server.logger.warning('Goal request callback did not return a GoalResponse type. Rejecting goal.')
        accepted = response is GoalResponse.ACCEPT
        handle = ServerGoalHandle(server, goal_id, goal)
        if accepted:
            self._handles[goal_id] = handle
        if not server.dispatch(server.reactor.on_goal_decision, goal_id, accepted, server.now()):
            self.forget(goal_id)  # it was refused, by the user or the policy
            return None
        return server.callbacks.accepted(handle)

    def handle(self, goal_id: GoalId) -> ServerGoalHandle | None:
        """Return the handle of a goal that has not ended."""
        return self._handles.get(goal_id)

    def goal_ids(self) -> list[GoalId]:
        """Return the goals that there are handles of."""
        return list(self._handles)

    def forget(self, goal_id: GoalId) -> None:
        """A goal has ended: nobody is asked about it any more."""
        self._handles.pop(goal_id, None)

    def forget_all(self) -> None:
        """The server goes away."""
        self._handles.clear()

    # -- cancelling ----------------------------------------------------------------------------------------

    def on_cancel(self, request: Request, message: tuple[GoalId, int]) -> Coroutine[Any, Any, None] | None:
        """A cancel request has come; it may mean many goals, and each is asked about once."""
        goal_id, stamp_ns = message
        server = self._server
        asked = server.dispatch(server.reactor.on_cancel_request, goal_id, stamp_ns, request, server.now())
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
            later = self._decide_cancels_later(pending, failures)
            return Enclosing(later, [coroutine for _, coroutine in pending])
        if failures:
            raise failures[0]
        return None

    def _ask_cancel(self, goal_id: GoalId, failures: list[BaseException]) -> object:
        handle = self._handles.get(goal_id)
        if handle is None:
            return CancelResponse.REJECT
        try:
            return self._server.callbacks.cancel(handle)
        except BaseException as error:
            failures.append(error)
            return CancelResponse.REJECT

    def _decide_cancel(self, ask: effect.AskCancel, answer: object) -> None:
        server = self._server
        accepted = answer is CancelResponse.ACCEPT
        server.dispatch(
            server.reactor.on_cancel_decision, ask.cancellation, ask.goal_id, accepted, server.now()
        )
        server.forget_ended(ask.goal_id)

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
