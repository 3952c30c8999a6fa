"""Missions that others ask for as goals of an action. A goal's id is its mission's, so asking twice is safe.

Whoever gives the orders chooses the id, for example from the number of an order. A goal whose mission was
begun before, also by an earlier runner of the same journal, begins nothing: it waits for that mission's end.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, TypeVar

from goalwire.errors import ClosedError, GoalAborted, JournalError, MissionIdTaken
from goalwire.rules.missions.entries import MissionState

if TYPE_CHECKING:
    import goalwire
    from goalwire.entities.actions.types import ActionClass
    from goalwire.missions.definition import Definition
    from goalwire.missions.mission_run import MissionRun
    from goalwire.missions.runner import Runner
    from goalwire.rules.missions.entries import Json

GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


def offer(
    node: goalwire.Node,
    runner: Runner,
    definition: Definition,
    action_type: ActionClass[GoalT, ResultT, FeedbackT],
    name: str,
    *,
    arguments: Callable[[GoalT], Sequence[Json]],
    result: Callable[..., ResultT],
    priority: Callable[[GoalT], int] = lambda _goal: 0,
) -> goalwire.ActionServer[GoalT, ResultT, FeedbackT]:
    """Serve an action whose goals are missions: each goal begins the mission of its id, or waits for it.

    `arguments(goal)` returns the mission's arguments, `priority(goal)` its priority in a runner that carries
    out one mission at a time, and `result(value)` the result's message for the mission's value. Cancelling
    the goal cancels the mission, and its undo steps run. A mission that fails aborts its goal; so does one
    whose id was used with other arguments. If the program ends before the mission, or if the journal cannot
    be read or written any more, the client hears that the server has gone, and not that the goal has ended:
    the next runner goes on with the mission. Raises as `Node.action_server` does.
    """

    def leave(error: JournalError) -> None:
        node.logger.error(f"Action '{name}' is not served any more, start this program again: {error}")
        server.close()

    async def carry_out(goal: goalwire.Goal[GoalT, FeedbackT]) -> ResultT:
        id_ = goal.goal_id.hex()
        request = goal.request
        beginning = asyncio.ensure_future(
            runner.start(definition, *arguments(request), id=id_, priority=priority(request))
        )
        try:
            # If the goal is cancelled while the mission is written, the mission begins all the same, and is
            # cancelled, too. Otherwise the next runner would find it in the journal and carry it out.
            run = await asyncio.shield(beginning)
            await run.ended.wait()
        except MissionIdTaken as error:
            raise GoalAborted(str(error)) from error
        except ClosedError:  # the runner has ended: maybe the mission is in the journal, maybe not
            server.close()
            raise asyncio.CancelledError from None
        except JournalError as error:  # a commit that failed may be on the disk nevertheless
            leave(error)
            raise asyncio.CancelledError from None
        except asyncio.CancelledError:
            await _take_back(runner, beginning, goal, server)
            raise
        if run.failure is not None:
            leave(run.failure)
            raise asyncio.CancelledError
        return _result_of(run, result)

    server = node.action_server(action_type, name, carry_out)
    server.leave_goals()
    return server


async def _take_back(
    runner: Runner,
    beginning: asyncio.Future[MissionRun],
    goal: goalwire.Goal[GoalT, FeedbackT],
    server: goalwire.ActionServer[GoalT, ResultT, FeedbackT],
) -> None:
    """Cancel the mission of a cancelled goal. If the next runner may go on with it, close the server: the
    client must not hear that the mission has ended.
    """
    try:
        await asyncio.wait([beginning])
        if beginning.exception() is None and goal.is_canceled and not server.is_closed:
            # If the runner is closing, or its journal is broken, the next one finds the mission.
            with suppress(ClosedError, JournalError):
                await runner.cancel(goal.goal_id.hex())
                await beginning.result().ended.wait()
    finally:
        if _goes_on(beginning):
            server.close()


def _goes_on(beginning: asyncio.Future[MissionRun]) -> bool:
    """Return whether the next runner may go on with a mission that this one does not carry out any more."""
    if not beginning.done() or isinstance(beginning.exception(), (ClosedError, JournalError)):
        return True
    return beginning.exception() is None and beginning.result().state.is_open


def _result_of(run: MissionRun, result: Callable[..., ResultT]) -> ResultT:
    if run.state is not MissionState.SUCCEEDED:
        raise GoalAborted(f'mission {run.row.id}: {run.state}{f": {run.why}" if run.why else ""}')
    return result(run.result)
