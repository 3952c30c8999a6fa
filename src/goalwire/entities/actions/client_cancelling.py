"""How an action client asks for cancellation: of one goal, of all, of those up to a time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NoReturn, cast

from goalwire.entities.actions.client_calls import ActionCalls
from goalwire.entities.actions.requests import LATE_S, ActionRequest, EncodedResponseFuture
from goalwire.errors import ClosedError, ShutDownError
from goalwire.execution.future import abandon, block_on
from goalwire.rules.goals import wire
from goalwire.rules.goals.ids import NO_ID
from goalwire.rules.time import S_TO_NS, Time

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time as StampMessage

    from goalwire.entities.call_context import CallContext
    from goalwire.execution.future import Future
    from goalwire.rules.goals.ids import GoalId


class Cancelling(ActionCalls):
    """The part of an action client that cancels."""

    def cancel_goal(
        self, goal_id: GoalId, stamp_ns: int = 0, call_context: CallContext | None = None
    ) -> Future[Any]:
        """Ask for cancellation; the future gives an action_msgs/srv/CancelGoal response."""
        self._check_alive()
        make = self.support.cancel_goal.decode_response
        future = EncodedResponseFuture(self, make, call_context or self.new_terms())
        payload = wire.encode_cancel_request(goal_id, stamp_ns)
        ActionRequest(self, self._cancel_port, payload, future).begin()
        return future

    def cancel_quietly(self, goal_id: GoalId) -> None:
        """Ask for cancellation, whatever the server says to that."""
        with suppress(ClosedError):
            asked = self.cancel_goal(goal_id, call_context=self.new_terms(LATE_S))
            asked.add_waker(lambda: cast('None', asked.exception()))  # looked at

    def cancel_all_goals_async(self) -> Future[CancelGoal.Response]:
        """Ask the server to cancel every goal, whoever has sent it; the future tells which it does."""
        return self.cancel_goal(NO_ID)

    def cancel_goals_before_async(self, stamp: Time | StampMessage) -> Future[CancelGoal.Response]:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises TypeError for what is no time, ValueError for one not above 0, which would stand for all goals.
        """
        if not (isinstance(stamp, Time) or hasattr(stamp, 'nanosec')):
            raise TypeError(f'a Time or a builtin_interfaces/msg/Time is needed, not {stamp!r}')
        stamp_ns = stamp.nanoseconds if isinstance(stamp, Time) else stamp.sec * S_TO_NS + stamp.nanosec
        if stamp_ns <= 0:
            raise ValueError(f'a time above 0 is needed, not {stamp}; cancel_all_goals cancels all')
        return self.cancel_goal(NO_ID, stamp_ns)

    def cancel_all_goals(self) -> CancelGoal.Response | None:
        """Ask as `cancel_all_goals_async` does, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.wait_for(self.cancel_all_goals_async)
        return answer

    def cancel_goals_before(self, stamp: Time | StampMessage) -> CancelGoal.Response | None:
        """Ask as `cancel_goals_before_async` does, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.wait_for(lambda: self.cancel_goals_before_async(stamp))
        return answer

    def _refuse_after_the_end(self) -> NoReturn:
        raise ShutDownError(f"action '{self.full_name}'")

    def wait_for(self, ask: Callable[[], Future[Any]]) -> Any:
        """Ask the server, block until the answer is there and return it; needs no executor.

        Raises WouldDeadlockError, with nothing asked, where the answer needs the thread that would wait;
        ShutDownError and InvalidHandle where the context ends, or this is destroyed, before it is there.
        """
        self.node.context.deadlock_detector.check(self.node.graph, self.goal_service)
        future = ask()
        self.blocking[future] = None
        try:
            self._check_alive()
            if not block_on(future, None, self.node.context.shutdown_signal):
                self._refuse_after_the_end()
        except BaseException:
            abandon(future)
            raise
        finally:
            self.blocking.pop(future, None)
        try:
            return future.result()
        finally:
            del future  # its exception's traceback holds this frame
