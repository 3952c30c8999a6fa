"""The action client of the asyncio API: it sends goals, and follows or probes goals that were sent before."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar, cast

from goalwire.aio.action.attached import AttachedRun
from goalwire.aio.action.probe import GoalProbe, GoalState, find_journal, probe_goal
from goalwire.aio.action.run import Limits, Run
from goalwire.aio.entity import Entity, message_of
from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.call_deadlines import CallContext
from goalwire.errors import CallError, InvalidHandle
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.rules.goals.cancel_requests import CancelCode, read_stamp
from goalwire.rules.goals.ids import NO_ID, read_goal_id
from goalwire.rules.goals.server_snapshot import ServerSnapshot, hash_of_statuses
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from uuid import UUID

    from builtin_interfaces.msg import Time as StampMessage

    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.statistics import ActionClientStatistics
    from goalwire.rules.time import Time

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')

__all__ = ['ActionClient', 'CancelAnswer', 'GoalProbe', 'GoalState', 'Run']


class CancelAnswer(NamedTuple):
    """A server's answer to a request to cancel goals."""

    code: CancelCode
    goals: tuple[bytes, ...]
    """The ids of the goals that the server cancels."""


class _Core(ActionClientCore):
    """The client's core. Its futures fail if no server answers."""

    @property
    def default_timeout(self) -> float:
        limit = super().default_timeout
        return inf if limit is None else limit

    def note_failure(self, goal_id: GoalId, reason: str) -> None:
        """Log nothing: the GoalAborted error that the caller gets contains the reason."""

    def server_is_there(self) -> bool:
        if self.destroyed:
            raise InvalidHandle
        return super().server_is_there()


class ActionClient(Entity, Generic[GoalT, ResultT, FeedbackT]):
    """Sends goals of one action. Made by Node.action."""

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
        goal_id: bytes | UUID | None = None,
        keep: bool = False,
        **fields: object,
    ) -> Run[ResultT, FeedbackT]:
        """Make a run of a goal, given or made of `fields`: `async with client.send(goal) as run:`.

        Entering the block waits for a server and sends the goal. Leaving the block cancels a goal that still
        runs and waits for its end, `grace` s at most. The server, its answer and the result must come within
        `timeout` s, or the client's timeout. If neither is given, only the server and its answer must come
        within the node's or the process's timeout for calls. A server counts as stuck if for `heartbeat` s it
        sends neither feedback nor a change of the goal's status.

        The goal gets the id `goal_id`, 16 bytes or a uuid.UUID, or else a new one. With `keep`, only
        `run.cancel` cancels the goal: it goes on if the block is left in any way, if it is accepted too late,
        or if its server counts as stuck. A goal is sent once.

        Raises TypeError for a goal, time or id of a wrong type. Raises ValueError for nan, for a heartbeat
        that is not above 0, and for an id of another length or of zeros only.
        """
        message = message_of(self._core.goal_type, goal, fields)
        limits = self._limits(timeout, grace, heartbeat)
        own_id = None if goal_id is None else read_goal_id(goal_id)
        return Run(self._core, message, limits, own_id, keep=keep)

    def _limits(self, timeout: float | None, grace: float, heartbeat: float | None) -> Limits:
        """Check the time limits before the goal is sent: an error afterwards would leave the goal without a
        run.
        """
        limit = self._timeout if timeout is None else timeout
        for what, given in (('timeout', limit), ('grace', grace), ('heartbeat', heartbeat)):
            if given is not None:
                timeout_ns(given, what)
        if heartbeat is not None and heartbeat <= 0:
            raise ValueError(f'a heartbeat is a time above 0 s, not {heartbeat}')
        return Limits(limit, grace, heartbeat)

    def attach(
        self, goal_id: bytes | UUID, *, timeout: float | None = None, heartbeat: float | None = None
    ) -> Run[ResultT, FeedbackT]:
        """Make a run of a goal that any client has sent before: `async with client.attach(id) as run:`.

        Only the request for the result is sent. Entering the block waits for a server. The run then has the
        feedback from now on, the status, the result and `cancel`. Leaving the block never cancels the goal.
        If the server does not know the goal, the result raises ServerLostError. The times mean the same as in
        `send`. Entering raises GoalIdTaken if this client follows that goal already. Raises as `send` does
        for a wrong time or id.
        """
        limits = self._limits(timeout, 0.0, heartbeat)
        return AttachedRun(self._core, read_goal_id(goal_id), limits)

    async def probe(self, goal_id: bytes | UUID, *, timeout: float = 10.0) -> GoalProbe[ResultT]:
        """Ask the server for the state of a goal that any client has sent before. The question changes
        nothing at the server. It takes 1 to 2 s for a running goal, 2 s for an unknown one, `timeout` s at
        most. If there is no server, if there are two, or if the server does not answer, the state is
        CANNOT_TELL. Raises InvalidHandle once closed, ShutDownError; TypeError and ValueError as `send` does
        for a time or an id.
        """
        timeout_ns(timeout, 'timeout')
        return await probe_goal(self._core, read_goal_id(goal_id), timeout)

    async def find_journal(self, *, timeout: float = 1.0) -> str | None:
        """Return the id of the server's journal; '' if it has none, None without an answer in `timeout` s.

        A server keeps a journal if it was made with `journal=`. Another id than before means that the server
        lost its journal, and with it its memory of earlier goals. Raises as `probe` does.
        """
        timeout_ns(timeout, 'timeout')
        return await find_journal(self._core, timeout)

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
        """Send a goal and wait for its result. Raises as a run does on entering and on awaiting its result.

        If the task that waits here is cancelled, the goal is cancelled, too.
        """
        message = cast('GoalT', message_of(self._core.goal_type, goal, fields))
        async with self.send(message, timeout=timeout, grace=grace, heartbeat=heartbeat) as run:
            return await run.result

    async def cancel_all_goals(self, *, timeout: float | None = None) -> CancelAnswer:
        """Ask the server to cancel every goal, also those of other clients.

        Raises NoServerError or DeadlineError after `timeout` s, if a timeout is given, ServerLostError,
        ServerFailedError; InvalidHandle once closed, ShutDownError.
        """
        return await self._cancel(0, timeout)

    async def cancel_goals_before(
        self, stamp: Time | StampMessage, *, timeout: float | None = None
    ) -> CancelAnswer:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises as `cancel_all_goals` does, and ValueError for a time that is not above 0.
        """
        return await self._cancel(read_stamp(stamp), timeout)

    async def _cancel(self, stamp_ns: int, timeout: float | None) -> CancelAnswer:
        """Ask the server to cancel all goals that it accepted at or before a time; 0 means every goal."""
        attempt = CallContext(self._core.node.context, 'action', self.name, timeout)
        await attempt.until(self._core.server_is_there, self._core.goal_service)
        asked = self._core.cancel_goal(NO_ID, stamp_ns)
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

    def server_snapshot(self) -> ServerSnapshot:
        """Return what this client sees of the server: its incarnation, and the goals in its status array."""
        core = self._core
        there = core.node.context.graph.entities(EndpointKind.SERVICE, core.goal_service)
        return ServerSnapshot(
            frozenset(each.gid.hex() for each in there), hash_of_statuses(core.streams.latest_statuses)
        )

    async def wait_for_server(self, *, timeout: float | None = None) -> None:
        """Wait until there is a server. Raises NoServerError, InvalidHandle once closed, ShutDownError."""
        attempt = CallContext(self._core.node.context, 'action', self.name, timeout)
        await attempt.until(self._core.server_is_there, self._core.goal_service)

    def statistics(self) -> ActionClientStatistics:
        """Return the counts of goals and feedback."""
        return self._core.statistics()

    def close(self) -> None:
        """Stop sending. Runs under way end with InvalidHandle, and their goals go on. Idempotent."""
        self._core.destroy()
