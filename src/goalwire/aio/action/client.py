"""Sends goals, and follows each from the beginning to the end of a block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from goalwire.aio.action.run import Run
from goalwire.aio.entity import Entity, message_of
from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.attempt import Attempt
from goalwire.entities.exceptions import InvalidHandle
from goalwire.execution.callback_groups import ReentrantCallbackGroup

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.execution.future import Future

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')

__all__ = ['ActionClient', 'Run']


class _Core(ActionClientCore):
    """A client whose futures fail where nobody answers."""

    def _on_failed(self, future: Future[Any], error: Exception) -> None:
        if future.pending():
            future.set_exception(InvalidHandle() if self.destroyed else error)

    def _report_lost(self, what: str, reason: str) -> None:
        """Nothing to log: it is raised where it is waited for."""

    def server_is_there(self) -> bool:
        if self.destroyed:
            raise InvalidHandle
        return super().server_is_there()


class ActionClient(Entity, Generic[GoalT, ResultT, FeedbackT]):
    """Made by Node.action."""

    def __init__(self, node: NodeCore, support: ActionSupport, name: str) -> None:
        self._core = _Core(node, support, name, ReentrantCallbackGroup())
        self.name = self._core.full_name

    def send(
        self,
        goal: GoalT | None = None,
        /,
        *,
        timeout: float | None = None,
        grace: float = 5.0,
        **fields: object,
    ) -> Run[ResultT, FeedbackT]:
        """Make a run of a goal (or of one made of `fields`): `async with client.send(goal) as run:`.

        Entering the block waits for a server and sends the goal, leaving it cancels a goal that still runs
        and waits for its end, `grace` s at most. The server, its answer and the result must be there within
        `timeout` s, if it is given. Raises TypeError for what is no such goal.
        """
        message = message_of(self._core.goal_type, goal, fields)
        return Run(self._core, message, timeout, grace)

    async def call(
        self,
        goal: GoalT | None = None,
        /,
        *,
        timeout: float | None = None,
        grace: float = 5.0,
        **fields: object,
    ) -> ResultT:
        """Send a goal and wait for its result; raises as entering a run and awaiting its result do.

        Cancelling this cancels the goal.
        """
        message = cast('GoalT', message_of(self._core.goal_type, goal, fields))
        async with self.send(message, timeout=timeout, grace=grace) as run:
            return await run.result

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        attempt = Attempt(self._core.node.context, 'action', self.name, timeout)
        await attempt.until(self._core.server_is_there, self._core.goal_service)

    def close(self) -> None:
        """Send no more; runs under way end with InvalidHandle, their goals go on. Idempotent."""
        self._core.destroy()
