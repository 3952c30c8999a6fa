"""Asks an action server about a goal that was sent before, only by requests for results.

A server answers a request for the result of an unknown goal at once, and that of a running goal when it ends.
So silence can mean two things: the goal runs, or the server has gone. A second request, with a new random id,
tells these apart: a running server answers it at once.
"""

from __future__ import annotations

from contextlib import suppress
from enum import Enum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.entities.call_deadlines import CallContext
from goalwire.errors import CallError, DeadlineError, NoServerError, RemoteError
from goalwire.execution.asyncio.waiting import settle
from goalwire.execution.future import Future
from goalwire.records import record
from goalwire.rules.goals.ids import new_goal_id
from goalwire.rules.goals.journal import RESULT_DROPPED, SERVER_DIED, journal_in
from goalwire.rules.goals.states import GoalStatus
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.rules.goals.ids import GoalId

ResultT = TypeVar('ResultT')

ASK_AGAIN_S = 1.0
"""How long, in s, to wait for one answer before the request is repeated: a new client's first request may be
lost.
"""
APART_S = 2.0
"""The time in s between two answers "unknown goal". A goal or a status array on its way arrives meanwhile."""
_SILENCES = 2
"""How many requests stay unanswered before a goal that is in no status array counts as running."""


class GoalState(Enum):
    """The state of a goal at its server."""

    RUNNING = 'running'
    """The goal has not ended: `attach` can follow it."""
    ENDED = 'ended'
    """The goal has ended, and the server has sent its result."""
    SERVER_DIED = 'server died'
    """The goal was begun, then its server died: it was executed in part, perhaps wholly. Only a server with a
    journal can tell this; others answer that they do not know the goal."""
    RESULT_GONE = 'result gone'
    """The goal has ended with the given status, but the server no longer has the result."""
    UNKNOWN = 'unknown'
    """The server does not know the goal. It never arrived, or was refused, or was forgotten after its end or
    a restart of the server: the answers do not tell which. A server with a journal does not forget."""
    CANNOT_TELL = 'cannot tell'
    """The state could not be found out; `why` has the reason. Do not send the goal again because of this."""


@record
class GoalProbe(Generic[ResultT]):
    """The answer of ActionClient.probe."""

    state: GoalState
    status: GoalStatus = GoalStatus.UNKNOWN
    """The last status that the server has published or answered; UNKNOWN if there was none."""
    result: ResultT | None = None
    """The result if the state is ENDED, whatever the status; otherwise None."""
    why: str = ''
    """The reason for the conclusion, in one sentence."""
    journal: str = ''
    """The id of the server's journal, if the state is UNKNOWN and it has one: it never accepted this goal
    since that journal was made."""


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


async def find_journal(core: ActionClientCore, timeout: float) -> str | None:
    """Return the id of the server's journal, '' if it has none; None without an answer within `timeout` s.

    Raises InvalidHandle, ShutDownError.
    """
    limit = CallContext(core.node.context, 'action', core.full_name, timeout)
    asked = core.results.ask_once(new_goal_id(), limit)
    try:
        await limit.settle(asked)
        _, text = asked.result()
    except (CallError, RemoteError):
        return None
    finally:
        asked.cancel()
        with suppress(Exception):
            asked.exception()  # read the error, or Python warns of it
    return journal_in(text)


class _Inquiry:
    """The questions about one goal, and the conclusion from the answers."""

    def __init__(self, core: ActionClientCore, goal_id: GoalId, limit: CallContext) -> None:
        self._core = core
        self._goal_id = goal_id
        self._limit = limit
        self.so_far = 'the server did not answer'
        """The reason why there is no conclusion yet."""

    async def conclude(self) -> GoalProbe[Any]:
        """Ask until there is a conclusion. Raises DeadlineError, and the error of a request that fails."""
        was_unknown = False
        silences = 0
        while True:
            answered, response, text = await self._ask()
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
            if text == SERVER_DIED:
                return GoalProbe(GoalState.SERVER_DIED, status, None, text)
            if text == RESULT_DROPPED:
                return GoalProbe(GoalState.RESULT_GONE, status, None, text)
            if status.is_terminal:
                return GoalProbe(GoalState.ENDED, status, response.result, 'the server gave its result')
            if was_unknown:
                return self._unknown(journal_in(text))
            was_unknown = True
            self.so_far = f'the server did not say twice, {APART_S:.0f} s apart, that it has no such goal'
            await self._pause(APART_S)

    def cannot_tell(self, why: str) -> GoalProbe[Any]:
        """Return an answer without a conclusion."""
        return GoalProbe(GoalState.CANNOT_TELL, self._core.streams.published_status(self._goal_id), None, why)

    def _unknown(self, journal: str) -> GoalProbe[Any]:
        status = self._core.streams.published_status(self._goal_id)
        if status.is_terminal:
            why = 'the status array says that it ended, and the server has no result of it'
            return GoalProbe(GoalState.RESULT_GONE, status, None, why)
        if journal:
            why = "it is not in the server's journal: it never arrived, or was refused"
        elif status.is_active:
            why = f'it was seen as {status.name}, and the server no longer knows it: it may have restarted'
        else:
            why = 'it never arrived, was refused, or has ended and was forgotten'
        return GoalProbe(GoalState.UNKNOWN, status, None, why, journal)

    async def _ask(self) -> tuple[bool, Any, str]:
        """Ask for the results of this goal and of a new random id.

        Return whether the request for the random id was answered, and the response for this goal or None,
        with the text that follows the response on the wire.
        """
        ours = self._core.results.ask_once(self._goal_id, self._limit)
        control = self._core.results.ask_once(new_goal_id(), self._limit)
        try:
            if not await self._wait(control, ASK_AGAIN_S) and ours.pending():
                return False, None, ''
            if control.done():
                control.result()
            self.so_far = 'the server answered, but there was no time for a conclusion,'
            await self._wait(ours, ASK_AGAIN_S)
            return True, *(ours.result() if ours.done() else (None, ''))
        finally:
            for asked in (ours, control):
                asked.cancel()
                with suppress(Exception):
                    asked.exception()  # read the error, or Python warns of it

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
