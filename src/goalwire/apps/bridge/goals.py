"""Goals that clients of a bridge send: each is followed until its end."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from typing import Any, Protocol

import goalwire
from goalwire.aio.action.run import Run
from goalwire.errors import GoalAborted, GoalCanceled, GoalwireError
from goalwire.records import record
from goalwire.rules.goals.states import GoalStatus


@record
class GoalEnd:
    """How a goal ended."""

    status: GoalStatus
    """The status of the goal; UNKNOWN if it never ran, or if its server was lost."""
    result: Any = None
    """The result message; None if there is none."""
    problem: str = ''
    """Why there is no result."""


class GoalListener(Protocol):
    """A client's interest in a goal."""

    def on_accepted(self, goal_id: bytes) -> None:
        """Note that the server has accepted the goal."""

    def on_feedback(self, feedback: Any) -> None:
        """Pass on feedback from the server."""


class SentGoal:
    """One goal. `follow` sends it; cancelling that coroutine cancels the goal."""

    def __init__(
        self,
        client: goalwire.ActionClient[Any, Any, Any],
        goal: Any,
        listener: GoalListener,
        patience: float,
    ) -> None:
        """Prepare to send the goal. The server must appear, and answer, within `patience` s."""
        self._client = client
        self._goal = goal
        self._listener = listener
        self._patience = patience
        self._run: Run[Any, Any] | None = None
        self._is_cancel_asked = False

    async def follow(self) -> GoalEnd:
        """Send the goal and wait for its end."""
        try:
            async with AsyncExitStack() as stack:
                try:
                    async with asyncio.timeout(self._patience):
                        await self._client.wait_for_server()
                        run = await stack.enter_async_context(self._client.send(self._goal))
                except TimeoutError:
                    name = self._client.name
                    return GoalEnd(
                        GoalStatus.UNKNOWN,
                        problem=f"action '{name}': no server took the goal within {self._patience} s",
                    )
                return await self._attend(run)
        except (GoalAborted, GoalCanceled) as error:
            status = GoalStatus.ABORTED if isinstance(error, GoalAborted) else GoalStatus.CANCELED
            return GoalEnd(status, error.result, str(error))
        except GoalwireError as error:
            return GoalEnd(GoalStatus.UNKNOWN, problem=str(error))

    async def _attend(self, run: Run[Any, Any]) -> GoalEnd:
        self._run = run
        self._listener.on_accepted(run.goal_id)
        if self._is_cancel_asked:
            await run.cancel(timeout=self._patience)
        async for feedback in run.feedback:
            self._listener.on_feedback(feedback)
        return GoalEnd(GoalStatus.SUCCEEDED, await run.result)

    async def cancel(self) -> bool:
        """Ask the server to cancel the running goal; return True if the server agrees.

        A goal that is not accepted yet is cancelled right after its acceptance. Raises CallError,
        ClosedError.
        """
        if self._run is None:
            self._is_cancel_asked = True
            return True
        return await self._run.cancel(timeout=self._patience)
