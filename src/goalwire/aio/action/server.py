"""The action server of the asyncio API. Each goal runs as a coroutine, which is cancelled with the goal."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from inspect import isawaitable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.aio.entity import Entity, message_of
from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    Failure,
    GoalResponse,
)
from goalwire.errors import GoalAborted
from goalwire.execution.callback_arguments import check_callback
from goalwire.execution.callback_groups import ReentrantCallbackGroup

if TYPE_CHECKING:
    from goalwire.entities.actions.server_goal_handle import ServerGoalHandle
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.server import GoalServer
    from goalwire.rules.statistics import ActionServerStatistics
    from goalwire.transport.contract import Request

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


class Goal(Generic[GoalT, FeedbackT]):
    """A goal that is passed to its handler."""

    def __init__(self, handle: ServerGoalHandle[GoalT, Any, FeedbackT], feedback_type: type) -> None:
        self._handle = handle
        self._feedback_type = feedback_type

    @property
    def request(self) -> GoalT:
        """The goal message that the client sent."""
        return self._handle.request

    @property
    def goal_id(self) -> bytes:
        """The goal's id, 16 bytes."""
        return self._handle.goal_id_bytes

    @property
    def is_canceled(self) -> bool:
        """True if the goal was cancelled. A handler is also cancelled, without this, when the node closes."""
        return self._handle.is_cancel_requested or not self._handle.is_active

    def feedback(self, message: FeedbackT | None = None, /, **fields: object) -> None:
        """Send feedback to the client: a message, or `fields` from which a message is made.

        Raises TypeError for another type, EncodeError, InvalidHandle once the server is closed.
        """
        feedback: Any = message_of(self._feedback_type, message, fields)
        self._handle.publish_feedback(feedback)


class ActionServer(Entity, Generic[GoalT, ResultT, FeedbackT]):
    """Serves one action. Made by Node.action_server."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        handler: Callable[[Goal[GoalT, FeedbackT]], Awaitable[ResultT]],
        accept: Callable[[GoalT], bool | Awaitable[bool]] | None,
        on_failure: Callable[[Goal[GoalT, FeedbackT], Exception], ResultT | None] | None,
        reactor: GoalServer[Request, bytes],
    ) -> None:
        for given, arguments, what in (
            (handler, ('goal',), 'the handler'),
            (accept, ('request',), 'accept'),
            (on_failure, ('goal', 'error'), 'on_failure'),
        ):
            if given is not None or given is handler:
                check_callback(given, arguments, f"{what} of the action '{name}'")
        self._handler = handler
        self._accept = accept
        self._on_failure = on_failure
        action: Any = support.cls
        self._result_type: type = action.Result
        self._feedback_type: type = action.Feedback
        self._running: dict[GoalId, asyncio.Task[Any]] = {}
        callbacks = ActionCallbacks(
            execute=self._execute,
            goal=self._take if accept is None else self._judge,
            accepted=lambda handle: handle.execute(),
            cancel=self._cancel,
            failed=None if on_failure is None else self._tell_failure,
            stopped_by_server=self._cancel,
        )
        self.name = node.resolve_action(name).name
        group = ReentrantCallbackGroup()
        self._core = ActionServerCore(node, support, name, callbacks, group, reactor=reactor)

    def _take(self, _goal: GoalT) -> GoalResponse:
        return GoalResponse.ACCEPT

    async def _judge(self, goal: GoalT) -> GoalResponse:
        assert self._accept is not None
        try:
            answer = self._accept(goal)
            accepted = await answer if isawaitable(answer) else answer
        except Exception as error:
            self._log('its accept function failed; the goal is refused', error)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT if accepted else GoalResponse.REJECT

    def _cancel(self, handle: ServerGoalHandle[Any, Any, Any]) -> CancelResponse:
        task = self._running.get(handle.goal_id_bytes)
        if task is not None:
            task.cancel()  # takes effect in a later turn of the loop, when the goal is CANCELING
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT]) -> object:
        """Run the handler and end the goal. The returned value is sent as its result."""
        task = asyncio.current_task()
        assert task is not None
        self._running[handle.goal_id_bytes] = task
        try:
            result = await self._run(handle)
        except asyncio.CancelledError:
            if handle.is_active and not handle.is_cancel_requested:
                raise  # the node is closing, since its block was left: the goal is aborted
            task.uncancel()
            result = None
        except GoalAborted as aborted:
            return self._abort(handle, Failure(aborted.result, str(aborted)))
        except Exception as error:
            self._log('its handler failed; the goal is aborted', error)
            return self._abort(handle, self._core.failure(handle, error), is_logged=True)
        finally:
            del self._running[handle.goal_id_bytes]
        return self.on_end(handle, result)

    async def _run(self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT]) -> ResultT | None:
        if handle.is_cancel_requested or not handle.is_active:
            return None  # the goal was cancelled before its handler began
        running = self._handler(Goal(handle, self._feedback_type))
        if not isawaitable(running):
            raise TypeError('the handler is a plain function, which holds up the loop: make it `async def`')
        return await running

    def on_end(self, handle: ServerGoalHandle[Any, Any, Any], result: object) -> object:
        if not handle.is_active:
            return Failure(result if isinstance(result, self._result_type) else None, 'its client has gone')
        if handle.is_cancel_requested:
            handle.canceled()
            return result if isinstance(result, self._result_type) else self._result_type()
        if not isinstance(result, self._result_type):
            wrong = type(result).__name__
            reason = f'its handler returned {wrong}, not {self._result_type.__name__}'
            return self._abort(handle, Failure(None, reason))
        handle.succeed()
        return result

    def _abort(
        self, handle: ServerGoalHandle[Any, Any, Any], failure: Failure, *, is_logged: bool = False
    ) -> Failure:
        if not is_logged:
            self._core.logger.warning(f"Action '{self.name}': the goal was aborted: {failure.reason}")
        if handle.is_active:
            handle.abort()
        return failure

    def _tell_failure(
        self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT], error: Exception
    ) -> ResultT | None:
        assert self._on_failure is not None
        return self._on_failure(Goal(handle, self._feedback_type), error)

    def _log(self, what: str, error: Exception) -> None:
        from goalwire.tracebacks import traceback_text

        self._core.logger.error(f"Action '{self.name}': {what}\n{traceback_text(error)}")

    def statistics(self) -> ActionServerStatistics:
        """Return the counts of goals, requests and feedback."""
        return self._core.statistics()

    def leave_goals(self) -> None:
        """Have the goals go on when the server closes: then it aborts none of them.

        For servers whose goals are carried out elsewhere. A client hears that the server has gone.
        """
        self._core.leaves_goals = True

    @property
    def is_closed(self) -> bool:
        """True once the server or its node was closed."""
        return self._core.destroyed

    def close(self) -> None:
        """Accept no more goals. Running goals are aborted, and their handlers cancelled. Idempotent."""
        self._core.destroy()
        calling = asyncio.current_task()
        for task in list(self._running.values()):
            if task is not calling:
                task.cancel()
