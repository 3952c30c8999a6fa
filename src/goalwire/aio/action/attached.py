"""A run that follows a goal which was sent before. It sends no goal."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from goalwire.aio.action.run import Limits, Run
from goalwire.entities.call_deadlines import CallContext

if TYPE_CHECKING:
    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.rules.goals.ids import GoalId

ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


class AttachedRun(Run[ResultT, FeedbackT]):
    """The run of a goal that was sent before: ActionClient.attach. The goal goes on after its block."""

    _not_entered = 'was not attached to: async with client.attach(…) as run:'

    def __init__(self, core: ActionClientCore, goal_id: GoalId, limits: Limits) -> None:
        super().__init__(core, None, limits, goal_id, keep=True)

    async def _begin(self, attempt: CallContext) -> None:
        """Wait for a server, then listen to the goal and ask for its result."""
        core = self._core
        waiting = attempt
        if self._limits.timeout is None:  # as for a new goal, only the wait for the server is limited
            waiting = CallContext(attempt.context, 'action', core.full_name, core.default_timeout)
        await waiting.until(core.server_is_there, core.goal_service)
        attempt.see_servers(core.goal_service)
        self._record = core.follow(self._id, self._stream)
        self._ask_result(attempt)
