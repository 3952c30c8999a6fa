"""A scripted action server: it follows the test's script, and remembers its goals."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic

from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import ActionCallbacks, CancelResponse, GoalResponse
from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.future import Future
from goalwire.testing.log import PATIENCE, Log, describe_differences
from goalwire.testing.spinning import host

if TYPE_CHECKING:
    from goalwire.entities.actions.server_goal_handle import ServerGoalHandle
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.rules.goals.ids import GoalId


@dataclass
class Conduct(Generic[GoalT, ResultT, FeedbackT]):
    """How a FakeAction treats goals. A change applies to later goals."""

    feedback: Iterable[FeedbackT] = ()
    """The feedback messages, published one after the other."""
    every: float = 0.1
    """Seconds between feedback messages, and from the last feedback message to the goal's end."""
    result: ResultT | Callable[[GoalT], ResultT] | None = None
    """The result of a goal; None: a result with default values."""
    refuse: bool | Callable[[GoalT], bool] = False
    """True to refuse all goals, or a function that returns True for a goal to refuse."""
    abort: bool = False
    """True if goals end as aborted instead of succeeded."""
    never_ends: bool = False
    """True if goals run on after their feedback, until they are cancelled."""
    cancel: bool = True
    """True if cancel requests are accepted."""


class FakeAction(Generic[GoalT, ResultT, FeedbackT]):
    """A scripted action server, made by Graph.action. It has its own node and thread."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        name: str,
        conduct: Conduct[GoalT, ResultT, FeedbackT],
    ) -> None:
        self._node = node
        action: Any = support.cls
        self._result_type: type[ResultT] = action.Result
        self.conduct = conduct
        """How goals are treated; its attributes may be changed at any time."""
        self.name = node.resolve_action(name).name
        self.goals: Log[GoalT] = Log(f"goals for '{self.name}'")
        """The accepted goals, in order."""
        self.refused: Log[GoalT] = Log(f"refused goals for '{self.name}'")
        self.cancels: Log[GoalT] = Log(f"cancelled goals of '{self.name}'")
        """The goals for which a cancel request came, whether it was accepted or not."""
        self.endings: Log[str] = Log(f"ended goals of '{self.name}'")
        """How each goal ended, in order: 'succeeded', 'aborted' or 'canceled'."""
        self._called_off: dict[GoalId, Future[None]] = {}
        callbacks = ActionCallbacks(
            execute=self._execute, goal=self._judge, accepted=self._accept, cancel=self._cancel
        )
        self._core = ActionServerCore(node, support, name, callbacks, ReentrantCallbackGroup())
        self._spinning = host(node)

    # -- the action's callbacks ------------------------------------------------------------------------------

    def _judge(self, goal: GoalT) -> GoalResponse:
        refuse = self.conduct.refuse
        refused = refuse(goal) if callable(refuse) else refuse
        (self.refused if refused else self.goals).append(goal)
        return GoalResponse.REJECT if refused else GoalResponse.ACCEPT

    def _accept(self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT]) -> None:
        self._called_off[handle.goal_id_bytes] = Future()
        handle.execute()

    def _cancel(self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT]) -> CancelResponse:
        self.cancels.append(handle.request)
        called_off = self._called_off.get(handle.goal_id_bytes)
        if not self.conduct.cancel or called_off is None:
            return CancelResponse.REJECT
        called_off.set_result(None)  # `_execute` sees it on this same thread, after the goal is CANCELING
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle[GoalT, ResultT, FeedbackT]) -> ResultT:
        conduct, called_off = self.conduct, self._called_off[handle.goal_id_bytes]
        try:
            for feedback in conduct.feedback:
                handle.publish_feedback(feedback)
                await _pause(called_off, conduct.every)
                if called_off.done():
                    break
            if conduct.never_ends:
                await called_off
            return self._end(handle, conduct)
        finally:
            del self._called_off[handle.goal_id_bytes]

    def _end(
        self,
        handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
        conduct: Conduct[GoalT, ResultT, FeedbackT],
    ) -> ResultT:
        result = conduct.result
        made: Any = result(handle.request) if callable(result) else result
        if handle.is_cancel_requested:
            ending = 'canceled'
            handle.canceled()
        elif conduct.abort:
            ending = 'aborted'
            handle.abort()
        else:
            ending = 'succeeded'
            handle.succeed()
        self.endings.append(ending)
        return self._result_type() if made is None else made

    # -- methods for tests -----------------------------------------------------------------------------------

    def wait_for(self, count: int = 1, *, timeout: float = PATIENCE) -> list[GoalT]:
        """Block until the server has accepted `count` goals; raises AssertionError after `timeout` s."""
        return self.goals.wait_for(count, timeout=timeout)

    def assert_goals(self, count: int) -> None:
        """Raise AssertionError unless exactly `count` goals were accepted."""
        if len(self.goals) != count:
            raise AssertionError(f"action '{self.name}': wanted {count} goals, got {self.goals}")

    def assert_goal(self, **fields: object) -> None:
        """Raise AssertionError unless the fields of the last accepted goal have these values."""
        if not self.goals:
            raise AssertionError(f"action '{self.name}' got no goal")
        wrong = describe_differences(self.goals[-1], fields)
        if wrong:
            raise AssertionError(f"action '{self.name}', last goal: {'; '.join(wrong)}")

    def close(self) -> None:
        """Close the server; running goals are aborted. May be called twice."""
        self._node.destroy()
        self._spinning.close()


async def _pause(called_off: Future[None], seconds: float) -> None:
    """Sleep, but return early if the goal is to be cancelled or aborted."""
    import asyncio

    try:
        async with asyncio.timeout(seconds):
            await called_off
    except TimeoutError:
        return
