"""A goal as its server's callbacks see it (rclpy.action.server.ServerGoalHandle)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic

from goalwire.entities.actions.goal_ids import goal_id_bytes, uuid_message
from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT
from goalwire.rules.goals.table import GoalEvent, GoalStatus

if TYPE_CHECKING:
    from action_msgs.msg import GoalInfo
    from unique_identifier_msgs.msg import UUID

    from goalwire.entities.actions.server import ActionServerCore
    from goalwire.rules.goals.ids import GoalId


class ServerGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    """What execute, cancel and handle_accepted callbacks get. It may outlive its goal."""

    __slots__ = ('__dict__', '__weakref__', '_server', '_uuid', 'goal_id_bytes', 'request')

    def __init__(
        self, action_server: ActionServerCore, goal_info: GoalId | GoalInfo, goal_request: GoalT
    ) -> None:
        """`goal_info` is the goal's id, as its bytes or as rclpy has it."""
        self._server = action_server
        self._uuid: UUID | None = None
        self.goal_id_bytes = goal_info if isinstance(goal_info, bytes) else goal_id_bytes(goal_info.goal_id)
        self.request = goal_request
        """The goal message that the client sent."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and other.goal_id_bytes == self.goal_id_bytes

    def __hash__(self) -> int:
        return hash(self.goal_id_bytes)

    @property
    def goal_id(self) -> UUID:
        """Its id."""
        if self._uuid is None:
            self._uuid = uuid_message(self.goal_id_bytes)
        return self._uuid

    @property
    def status(self) -> int:
        """Its action_msgs/msg/GoalStatus number; STATUS_UNKNOWN once forgotten."""
        return int(self._status)

    @property
    def _status(self) -> GoalStatus:
        return self._server.goal_status(self.goal_id_bytes)

    @property
    def is_active(self) -> bool:
        """True until it has ended."""
        return self._status.is_active

    @property
    def is_cancel_requested(self) -> bool:
        """True once a cancel request was accepted, until the goal has ended."""
        return self._status is GoalStatus.CANCELING

    def execute(
        self,
        execute_callback: Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], object] | None = None,
    ) -> None:
        """Start the execute callback, the server's own unless one is given.

        Raises RCLError for a goal that was executed before or has ended.
        """
        self._server.start_execution(self, execute_callback)

    def publish_feedback(self, feedback: FeedbackT) -> None:
        """Send feedback to the goal's client. Raises TypeError for what is not the action's Feedback."""
        self._server.publish_feedback(self, feedback)

    def succeed(self) -> None:
        """End it SUCCEEDED; raises RCLError where its state does not allow that."""
        self._server.end(self, GoalEvent.SUCCEED)

    def abort(self) -> None:
        """End it ABORTED; raises RCLError where its state does not allow that."""
        self._server.end(self, GoalEvent.ABORT)

    def canceled(self) -> None:
        """End it CANCELED, after is_cancel_requested; raises RCLError where its state does not allow that."""
        self._server.end(self, GoalEvent.CANCELED)

    def destroy(self) -> None:
        """Nothing to release; kept for rclpy's programs."""
