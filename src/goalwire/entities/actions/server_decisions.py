"""The program's decisions for an action server: which goals it accepts, and which cancellations.

A callback that raises counts as a refusal, and its exception propagates.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    GoalServing,
    ServerGoalHandle,
)
from goalwire.entities.coroutines import Enclosing
from goalwire.errors import JournalError
from goalwire.rules.goals import effects as effect

if TYPE_CHECKING:
    from goalwire.entities.actions.advice import ActionAdvice
    from goalwire.entities.actions.journal_file import JournalFile
    from goalwire.entities.actions.lost_clients import ClientWatch
    from goalwire.entities.actions.server_results import ServerResults
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.server import GoalServer
    from goalwire.transport.contract import Request


class DecidingServer(GoalServing, Protocol):
    """An action server as the program's decisions see it (ActionServerCore)."""

    callbacks: ActionCallbacks
    reactor: GoalServer[Request, bytes]
    results: ServerResults
    now: Callable[[], int]
    clients: ClientWatch | None
    """Watches for clients that go; None if their goals go on all the same."""
    advice: ActionAdvice | None
    """Logs mistakes in the program's callbacks."""

    def dispatch(self, event: Callable[..., Any], *args: Any) -> effect.ServerEffects[Request, bytes]:
        """Feed the reactor, perform its effects on the wire, return the effects that call the program."""

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
        if server.results.journal is not None:
            return Enclosing(self._decide_by_journal(goal_id, goal, server.results.journal), ())
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

    async def _decide_by_journal(self, goal_id: GoalId, goal: Any, journal: JournalFile) -> None:
        """Ask the program unless the journal has the id; write to the journal that the goal begins, before it
        does.
        """
        server = self._server
        response: object = GoalResponse.REJECT
        has_begun = False
        try:
            if await journal.find(goal_id) is not None:
                server.results.warn_known(goal_id)
            else:
                response = server.callbacks.goal(goal)
                if isinstance(response, CoroutineType):
                    response = await response
            if response is GoalResponse.ACCEPT:
                has_begun = await journal.begin(goal_id)
        except JournalError as error:
            server.results.log_refusal(error)
        except BaseException:
            self._decide(goal_id, goal, GoalResponse.REJECT)
            raise
        if response is GoalResponse.ACCEPT and not has_begun:
            response = GoalResponse.REJECT
        handle = self._settle(goal_id, goal, response)
        if handle is not None:
            outcome = server.callbacks.accepted(handle)
            if isinstance(outcome, CoroutineType):
                await outcome
        elif has_begun:  # refused after all, by the policy or since its client has gone: it will never run
            journal.forget(goal_id).add_done_callback(lambda forgotten: forgotten.exception())

    def _decide(self, goal_id: GoalId, message: Any, response: object) -> object:
        handle = self._settle(goal_id, message, response)
        return None if handle is None else self._server.callbacks.accepted(handle)

    def _settle(self, goal_id: GoalId, message: Any, response: object) -> ServerGoalHandle | None:
        """Tell the reactor the decision, and return the goal's handle; None if the program or the policy
        refuses it.
        """
        server = self._server
        if server.advice is not None and not isinstance(response, GoalResponse):
            server.advice.no_response(server.callbacks.goal, response, GoalResponse)
        goal = server.reactor.deciding.get(goal_id)  # None: the client or the server has gone
        handle = None if goal is None else ServerGoalHandle(server, goal, message)
        is_accepted = response is GoalResponse.ACCEPT
        asked = server.dispatch(server.reactor.on_goal_decision, goal_id, is_accepted, server.now(), handle)
        return handle if asked else None

    def on_cancel(self, request: Request, message: tuple[GoalId, int]) -> Coroutine[Any, Any, None] | None:
        """Ask the program about a cancel request that has come: once for each goal that it covers."""
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
                if goal is not None and goal.handle is not None:  # else the goal has ended meanwhile
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
