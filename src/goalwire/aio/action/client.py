"""An action client of the asyncio API: sends goals; `async with` follows each from its sending to its end."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar, cast

from goalwire.aio.action.run import Limits, Run
from goalwire.aio.entity import Entity, message_of
from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.call_context import CallContext
from goalwire.errors import CallError, InvalidHandle
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.monotonic import timeout_ns
from goalwire.rules.goals.cancel import CancelCode

if TYPE_CHECKING:
    from collections.abc import Callable

    from builtin_interfaces.msg import Time as StampMessage

    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.execution.future import Future
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.statistics import ActionClientStatistics
    from goalwire.rules.time import Time

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')

__all__ = ['ActionClient', 'CancelAnswer', 'Run']


class CancelAnswer(NamedTuple):
    """A server's answer to a request to cancel goals."""

    code: CancelCode
    goals: tuple[bytes, ...]
    """The ids of those that it cancels."""


class _Core(ActionClientCore):
    """A client whose futures fail if nobody answers."""

    @property
    def default_timeout(self) -> float:
        limit = super().default_timeout
        return inf if limit is None else limit

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """GoalAborted says it."""

    def server_is_there(self) -> bool:
        if self.destroyed:
            raise InvalidHandle
        return super().server_is_there()


class ActionClient(Entity, Generic[GoalT, ResultT, FeedbackT]):
    """Made by Node.action."""

    def __init__(
        self, node: NodeCore, support: ActionSupport, name: str, timeout: float | None = None
    ) -> None:
        self._core = _Core(node, support, name, ReentrantCallbackGroup())
        self._timeout = timeout
        self.name = self._core.full_name

    def send(
        self,
        goal: GoalT | None = None,
        /,
        *,
        timeout: float | None = None,
        grace: float = 5.0,
        heartbeat: float | None = None,
        **fields: object,
    ) -> Run[ResultT, FeedbackT]:
        """Make a run of a goal (or of one made of `fields`): `async with client.send(goal) as run:`.

        Entering the block waits for a server and sends the goal, leaving it cancels a goal that still runs
        and waits for its end, `grace` s at most. The server, its answer and the result must be there within
        `timeout` s, or the client's; where neither is given, only the server and its answer have a time, if
        the node or the process has one for calls. A server that gives no sign of life for `heartbeat` s,
        neither feedback nor a change of the goal's status, counts as stuck. Raises TypeError for what is no
        such goal or time, ValueError for nan and a heartbeat that is not above 0.
        """
        message = message_of(self._core.goal_type, goal, fields)
        limit = self._timeout if timeout is None else timeout
        for what, given in (('timeout', limit), ('grace', grace), ('heartbeat', heartbeat)):
            if given is not None:
                timeout_ns(given, what)  # before anything is sent, which an error would leave behind
        if heartbeat is not None and heartbeat <= 0:
            raise ValueError(f'a heartbeat is a time above 0 s, not {heartbeat}')
        return Run(self._core, message, Limits(limit, grace, heartbeat))

    async def call(
        self,
        goal: GoalT | None = None,
        /,
        *,
        timeout: float | None = None,
        grace: float = 5.0,
        heartbeat: float | None = None,
        **fields: object,
    ) -> ResultT:
        """Send a goal and wait for its result; raises as entering a run and awaiting its result do.

        Cancelling this cancels the goal.
        """
        message = cast('GoalT', message_of(self._core.goal_type, goal, fields))
        async with self.send(message, timeout=timeout, grace=grace, heartbeat=heartbeat) as run:
            return await run.result

    async def cancel_all_goals(self, *, timeout: float | None = None) -> CancelAnswer:
        """Ask the server to cancel every goal, whoever has sent it.

        Raises NoServerError or DeadlineError at the end of `timeout` s, if it is given, ServerLostError,
        ServerFailedError; InvalidHandle once closed, ShutDownError.
        """
        return await self._cancel(self._core.cancel_all_goals_async, timeout)

    async def cancel_goals_before(
        self, stamp: Time | StampMessage, *, timeout: float | None = None
    ) -> CancelAnswer:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises as `cancel_all_goals` does, and ValueError for a time that is not above 0.
        """
        return await self._cancel(lambda: self._core.cancel_goals_before_async(stamp), timeout)

    async def _cancel(self, ask: Callable[[], Future[Any]], timeout: float | None) -> CancelAnswer:
        attempt = CallContext(self._core.node.context, 'action', self.name, timeout)
        await attempt.until(self._core.server_is_there, self._core.goal_service)
        asked = ask()
        try:
            await attempt.settle(asked)
            response: Any = asked.result()
        except CallError as error:
            raise attempt.retell(error) from None
        finally:
            if asked.pending():
                asked.cancel()
        goals = tuple(bytes(goal.goal_id.uuid) for goal in response.goals_canceling)
        return CancelAnswer(CancelCode(response.return_code), goals)

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        attempt = CallContext(self._core.node.context, 'action', self.name, timeout)
        await attempt.until(self._core.server_is_there, self._core.goal_service)

    def statistics(self) -> ActionClientStatistics:
        """Count goals and feedback."""
        return self._core.statistics()

    def close(self) -> None:
        """Send no more; runs under way end with InvalidHandle, their goals go on. Idempotent."""
        self._core.destroy()
