"""A goal as its client sees it (rclpy.action.client.ClientGoalHandle)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, Protocol

from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT, goal_id_bytes, uuid_message
from goalwire.rules.goals.table import GoalStatus

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time
    from unique_identifier_msgs.msg import UUID

    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.entities.actions.types import ResultResponse
    from goalwire.execution.future import Future
    from goalwire.rules.goals.ids import GoalId
    from goalwire.transport.contract import Sample


class FeedbackQueue(Protocol):
    """Where the feedback of one goal waits to be used."""

    def deliver(self, event: Sample, /) -> object:
        """Queue a message as it came from the wire. Any thread."""

    def close(self) -> None:
        """Drop what waits and refuse what comes."""

    @property
    def dropped(self) -> int:
        """How many messages found it full."""


class ClientGoal:
    """What the client keeps of one goal: where it stands, and the queue of its feedback."""

    __slots__ = ('answered', 'feedback', 'goal_id', 'heard', 'reason', 'sent_at', 'status')

    def __init__(self, goal_id: GoalId, feedback: FeedbackQueue | None, sent_at: int = 0) -> None:
        self.goal_id = goal_id
        self.feedback = feedback
        self.sent_at = sent_at
        """When, in ns since the UNIX epoch; 0 where it was not sent by this client."""
        self.answered = False
        """True once a server has accepted or refused it."""
        self.status = GoalStatus.UNKNOWN
        self.reason = ''
        """Why it was aborted, in the words of a server that knows goalwire."""
        self.heard: Callable[[], object] | None = None
        """Called at each sign of life: feedback, and every change of the status."""

    @property
    def dropped(self) -> int:
        """How many feedback messages found the queue full."""
        return 0 if self.feedback is None else self.feedback.dropped

    def advance(self, status: GoalStatus) -> None:
        """Note a status. It only moves forward, and a terminal one is final."""
        if not self.status.is_terminal and status > self.status:
            self.status = status
            if self.heard is not None:
                self.heard()


class ClientGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    """What send_goal's future gives: was it accepted, where does it stand, its result, its cancellation."""

    def __init__(
        self, action_client: ActionClientCore, goal_id: ClientGoal | UUID, goal_response: Any
    ) -> None:
        """`goal_id` is what `action_client` keeps of a goal, or the id that it was sent with.

        `goal_response` is the action's SendGoal response.
        """
        self._action_client = action_client
        self._goal = (
            goal_id if isinstance(goal_id, ClientGoal) else action_client.goal(goal_id_bytes(goal_id))
        )
        self._goal_response = goal_response

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and other._goal.goal_id == self._goal.goal_id

    __hash__ = None  # type: ignore[assignment]  # as in rclpy

    def __repr__(self) -> str:
        status = int(self._goal.status)
        return f'ClientGoalHandle <id={self.goal_id.uuid}, accepted={self.accepted}, status={status}>'

    @property
    def goal_id(self) -> UUID:
        """Its id."""
        return uuid_message(self._goal.goal_id)

    @property
    def stamp(self) -> Time:
        """When the server accepted it; zero where it did not."""
        stamp: Time = self._goal_response.stamp
        return stamp

    @property
    def accepted(self) -> bool:
        """True where the server accepted it."""
        return bool(self._goal_response.accepted)

    @property
    def status(self) -> int:
        """Its action_msgs/msg/GoalStatus number, as far as is known here."""
        return int(self._goal.status)

    @property
    def reason(self) -> str:
        """Why it was aborted, where its server runs on goalwire; known with the result, else ''."""
        return self._goal.reason

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Ask for cancellation and wait for the answer; raises ShutDownError or InvalidHandle at the end."""
        answer: CancelGoal.Response | None = self._action_client.wait_for(self.cancel_goal_async)
        return answer

    def cancel_goal_async(self) -> Future[CancelGoal.Response]:
        """Ask for cancellation; the future tells which goals will be cancelled."""
        return self._action_client.cancel_goal(self._goal.goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Wait for the end and return status and result. Raises as cancel_goal does."""
        answer: ResultResponse[ResultT] | None = self._action_client.wait_for(self.get_result_async)
        return answer

    def get_result_async(self) -> Future[ResultResponse[ResultT]]:
        """Ask for the result; the future gives status and result (the action's GetResult response)."""
        return self._action_client.get_result(self._goal.goal_id)
