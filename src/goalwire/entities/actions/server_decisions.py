"""The program's decisions for an action server: which goals it accepts, and which cancellations.

A callback that fails has refused, and its error goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.entities.actions.server_goal import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    GoalServing,
    ServerGoalHandle,
)
from goalwire.entities.coroutines import Enclosing
from goalwire.rules.goals import effects as effect

if TYPE_CHECKING:
    from goalwire.entities.actions.advice import ActionAdvice
    from goalwire.entities.actions.client_watch import ClientWatch
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.server import GoalServer
    from goalwire.transport.contract import Request


class DecidingServer(GoalServing, Protocol):
    """An action server as the program's decisions see it (ActionServerCore)."""

    callbacks: ActionCallbacks
    reactor: GoalServer[Request, bytes]
    now: Callable[[], int]
    clients: ClientWatch | None
    """Clients that have gone; None if that makes no difference."""
    advice: ActionAdvice | None
    """Tells what the program's callbacks got wrong."""

    def dispatch(self, event: Callable[..., Any], *args: Any) -> effect.ServerEffects[Request, bytes]:
        """Feed the reactor, perform its effects on the wire, return those that call the user."""

    def end_goals_of(self, client: bytes) -> None:
        """Refuse, cancel or abort the goals of a client that has gone."""


class ServerDecisions:
    """Asks the program about each goal and each cancellation, and tells the reactor its answers."""

    def __init__(self, server: DecidingServer) -> None:
        self._server = server

    def on_goal(self, request: Request, message: tuple[GoalId, Any]) -> object:
        """Ask the program about a goal that has come."""
        server = self._server
        goal_id, goal = message
        client = request.sample.gid
        if not server.dispatch(server.reactor.on_goal_request, goal_id, request, server.now(), client):
            return None
        if server.clients is not None and server.clients.has_lost(client):
            server.end_goals_of(client)  # the client has gone while its goal waited for the executor
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

    def _decide(self, goal_id: GoalId, message: Any, response: object) -> object:
        server = self._server
        if server.advice is not None and not isinstance(response, GoalResponse):
            server.advice.no_response(server.callbacks.goal, response, GoalResponse)
        goal = server.reactor.deciding.get(goal_id)  # None: its client has gone, or the server was destroyed
        handle = None if goal is None else ServerGoalHandle(server, goal, message)
        is_accepted = response is GoalResponse.ACCEPT
        asked = server.dispatch(server.reactor.on_goal_decision, goal_id, is_accepted, server.now(), handle)
        if handle is None or not asked:
            return None  # refused by the user or the policy
        return server.callbacks.accepted(handle)

    def on_cancel(self, request: Request, message: tuple[GoalId, int]) -> Coroutine[Any, Any, None] | None:
        """Ask the program about a cancel request that has come: once for each goal that it means."""
        server = self._server
        goal_id, stamp_ns = message
        asked = server.dispatch(server.reactor.on_cancel_request, goal_id, stamp_ns, request, server.now())
        pending: list[tuple[effect.AskCancel, Coroutine[Any, Any, Any]]] = []
        failures: list[BaseException] = []
        for ask in asked:
            assert isinstance(ask, effect.AskCancel)
            goal = server.reactor.goals.get(ask.goal_id)
            answer: object = CancelResponse.REJECT
            try:
                if goal is not None and goal.handle is not None:  # otherwise the goal has ended meanwhile
                    answer = server.callbacks.cancel(goal.handle)
            except BaseException as error:
                failures.append(error)
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

    def _decide_cancel(self, ask: effect.AskCancel, answer: object) -> None:
        server = self._server
        is_accepted = answer is CancelResponse.ACCEPT
        if server.advice is not None:
            goal = server.reactor.goals.get(ask.goal_id)
            server.advice.on_cancel_answer(None if goal is None else goal.handle, server.callbacks, answer)
        server.dispatch(
            server.reactor.on_cancel_decision, ask.cancellation, ask.goal_id, is_accepted, server.now()
        )

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
