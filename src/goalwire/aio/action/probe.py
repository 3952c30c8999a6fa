"""Asks an action server about a goal that was sent before, without sending anything but requests for results.

A server answers a request for the result of an unknown goal at once, and that of a running goal when it ends.
So silence can mean two things: the goal runs, or the server is away. A second request, for an id that was
just made up, tells these apart: a server that is there answers it at once.
"""

from __future__ import annotations

from contextlib import suppress
from enum import Enum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.entities.call_context import CallContext
from goalwire.errors import CallError, DeadlineError, NoServerError, RemoteError
from goalwire.execution.asyncio.waiting import settle
from goalwire.execution.future import Future
from goalwire.records import record
from goalwire.rules.goals.ids import new_goal_id
from goalwire.rules.goals.table import GoalStatus
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.rules.goals.ids import GoalId

ResultT = TypeVar('ResultT')

ASK_AGAIN_S = 1.0
"""How long one answer is waited for: the first request of a new client may be lost in discovery."""
APART_S = 2.0
"""Between two answers that the goal is unknown: meanwhile a goal on its way arrives, and the status array."""
_SILENCES = 2
"""How often the server has to be silent about a goal that is in no status array before it counts as known."""


class GoalState(Enum):
    """How a goal stands with its server."""

    RUNNING = 'running'
    """The server has it, and it has not ended: `attach` follows it."""
    ENDED = 'ended'
    """It has ended, and the server still had its result."""
    RESULT_GONE = 'result gone'
    """It has ended as the status says; the server no longer has the result."""
    UNKNOWN = 'unknown'
    """The server does not have it. It never arrived, was refused, or was forgotten after its end or with a
    restart of the server: servers do not tell these apart."""
    CANNOT_TELL = 'cannot tell'
    """No conclusion; `why` says the reason. Never send the goal again on this."""


@record
class GoalProbe(Generic[ResultT]):
    """The answer of ActionClient.probe."""

    state: GoalState
    status: GoalStatus = GoalStatus.UNKNOWN
    """The last that the server has published or answered; UNKNOWN if it has said nothing of the goal."""
    result: ResultT | None = None
    """The result of a goal that has ENDED, whatever its status; else None."""
    why: str = ''
    """How this is known, in a sentence."""


async def probe_goal(core: ActionClientCore, goal_id: GoalId, timeout: float) -> GoalProbe[Any]:
    """Ask until there is a conclusion, `timeout` s at most. Raises InvalidHandle, ShutDownError."""
    limit = CallContext(core.node.context, 'action', core.full_name, timeout)
    inquiry = _Inquiry(core, goal_id, limit)
    try:
        await limit.until(core.server_is_there, core.goal_service)
        if len(limit.servers) > 1:
            peers = ' and '.join(limit.peers)
            return inquiry.cannot_tell(
                f'{len(limit.servers)} servers have this name ({peers}), and any may answer'
            )
        found = await inquiry.conclude()
    except DeadlineError:
        return inquiry.cannot_tell(f'{inquiry.so_far} within {timeout} s')
    except NoServerError as error:
        return inquiry.cannot_tell(str(error))
    except CallError as error:
        return inquiry.cannot_tell(str(limit.retell(error)))
    except RemoteError as error:
        return inquiry.cannot_tell(f'its answer cannot be read: {error}')
    now_there = core.node.context.graph.entities(EndpointKind.SERVICE, core.goal_service)
    if {each.gid for each in now_there} != {each.gid for each in limit.servers}:
        return inquiry.cannot_tell('the server went away, or another came, while it was asked')
    return found


class _Inquiry:
    """The questions about one goal, and the conclusion from the answers."""

    def __init__(self, core: ActionClientCore, goal_id: GoalId, limit: CallContext) -> None:
        self._core = core
        self._goal_id = goal_id
        self._limit = limit
        self.so_far = 'the server did not answer'
        """Why there is no conclusion yet."""

    async def conclude(self) -> GoalProbe[Any]:
        """Ask again and again. Raises DeadlineError, and whatever ends a request."""
        was_unknown = False
        silences = 0
        while True:
            answered, response = await self._ask()
            if response is None:
                silences += answered
                status = self._core.streams.published_status(self._goal_id)
                if silences >= _SILENCES or (silences and status.is_active):
                    why = 'the server answers at once for another id, and keeps this request until the end'
                    return GoalProbe(GoalState.RUNNING, status, None, why)
                continue
            if response.status > GoalStatus.ABORTED or 0 < response.status < GoalStatus.SUCCEEDED:
                return self.cannot_tell(f'the server gave a result of status {response.status}')
            status = GoalStatus(response.status)
            if status.is_terminal:
                return GoalProbe(GoalState.ENDED, status, response.result, 'the server gave its result')
            if was_unknown:
                return self._unknown()
            was_unknown = True
            self.so_far = f'the server did not say twice, {APART_S:.0f} s apart, that it has no such goal'
            await self._pause(APART_S)

    def cannot_tell(self, why: str) -> GoalProbe[Any]:
        """Return an answer without a conclusion."""
        return GoalProbe(GoalState.CANNOT_TELL, self._core.streams.published_status(self._goal_id), None, why)

    def _unknown(self) -> GoalProbe[Any]:
        status = self._core.streams.published_status(self._goal_id)
        if status.is_terminal:
            why = 'the status array says that it ended, and the server has no result of it'
            return GoalProbe(GoalState.RESULT_GONE, status, None, why)
        if status.is_active:
            why = f'it was seen as {status.name}, and the server no longer knows it: it may have restarted'
        else:
            why = 'it never arrived, was refused, or has ended and was forgotten'
        return GoalProbe(GoalState.UNKNOWN, status, None, why)

    async def _ask(self) -> tuple[bool, Any]:
        """Ask for this goal's result and that of an id nobody has: was the latter answered, and the former.

        The former's response is None if there was none.
        """
        ours = self._core.results.ask_once(self._goal_id, self._limit)
        control = self._core.results.ask_once(new_goal_id(), self._limit)
        try:
            if not await self._wait(control, ASK_AGAIN_S) and ours.pending():
                return False, None
            if control.done():
                control.result()
            self.so_far = 'the server answered, but there was no time for a conclusion,'
            await self._wait(ours, ASK_AGAIN_S)
            return True, (ours.result() if ours.done() else None)
        finally:
            for asked in (ours, control):
                asked.cancel()
                with suppress(Exception):
                    asked.exception()  # the exception counts as seen

    async def _pause(self, seconds: float) -> None:
        await self._wait(Future(), seconds)

    async def _wait(self, future: Future[Any], seconds: float) -> bool:
        """Wait for a future: False after `seconds`. Raises DeadlineError, ShutDownError."""
        limit = self._limit
        until = limit.now() + int(seconds * 1e9)
        if limit.deadline is not None:
            until = min(until, limit.deadline)
        if await settle(future, limit.context.shutdown_signal, until):
            return True
        limit.check_alive()
        if limit.deadline is not None and limit.now() >= limit.deadline:
            raise limit.error(DeadlineError, self.so_far)
        return False
