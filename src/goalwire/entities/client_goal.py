"""A goal as its client sees it (rclpy.action.client.ClientGoalHandle)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.protocol.goals.table import GoalStatus

if TYPE_CHECKING:
    from goalwire.entities.action_client import ActionClientCore
    from goalwire.execution.future import Future
    from goalwire.execution.inbox import Inbox
    from goalwire.protocol.goals.ids import GoalId
    from goalwire.transport.contract import Sample


class ClientGoal:
    """What the client keeps of one goal: where it stands, and the queue of its feedback."""

    __slots__ = ('answered', 'feedback', 'goal_id', 'status')

    def __init__(self, goal_id: GoalId, feedback: Inbox[Sample] | None) -> None:
        self.goal_id = goal_id
        self.feedback = feedback
        self.answered = False
        """True once a server has accepted or refused it."""
        self.status = GoalStatus.UNKNOWN

    def advance(self, status: GoalStatus) -> None:
        """Note a status. It only moves forward, and a terminal one is final."""
        if not self.status.is_terminal and status > self.status:
            self.status = status


class ClientGoalHandle:
    """What send_goal's future gives: was it accepted, where does it stand, its result, its cancellation."""

    def __init__(self, action_client: ActionClientCore, goal: ClientGoal, goal_response: Any) -> None:
        self._action_client = action_client
        self._goal = goal
        self._goal_response = goal_response

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and other._goal.goal_id == self._goal.goal_id

    __hash__ = None  # type: ignore[assignment]  # as in rclpy

    def __repr__(self) -> str:
        status = int(self._goal.status)
        return f'ClientGoalHandle <id={self.goal_id.uuid}, accepted={self.accepted}, status={status}>'

    @property
    def goal_id(self) -> Any:
        """Its unique_identifier_msgs/msg/UUID."""
        from goalwire.entities.goal_ids import uuid_message

        return uuid_message(self._goal.goal_id)

    @property
    def stamp(self) -> Any:
        """When the server accepted it (builtin_interfaces/msg/Time; zero where it did not)."""
        return self._goal_response.stamp

    @property
    def accepted(self) -> bool:
        """True where the server accepted it."""
        return bool(self._goal_response.accepted)

    @property
    def status(self) -> int:
        """Its action_msgs/msg/GoalStatus number, as far as is known here."""
        return int(self._goal.status)

    def cancel_goal(self) -> Any:
        """Ask for cancellation and wait for the answer, an action_msgs/srv/CancelGoal response."""
        return self._action_client.wait_for(self.cancel_goal_async)

    def cancel_goal_async(self) -> Future[Any]:
        """Ask for cancellation; the future gives an action_msgs/srv/CancelGoal response."""
        return self._action_client.cancel_goal(self._goal.goal_id)

    def get_result(self) -> Any:
        """Wait for the end and return status and result (the action's GetResult response)."""
        return self._action_client.wait_for(self.get_result_async)

    def get_result_async(self) -> Future[Any]:
        """Ask for the result; the future gives status and result (the action's GetResult response)."""
        return self._action_client.get_result(self._goal.goal_id)
