"""A goal as its server's callbacks see it (rclpy.action.server.ServerGoalHandle)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from goalwire.protocol.goals.table import GoalEvent, GoalStatus

if TYPE_CHECKING:
    from goalwire.entities.action_server import ActionServerCore
    from goalwire.protocol.goals.ids import GoalId


class ServerGoalHandle:
    """What execute, cancel and handle_accepted callbacks get. It may outlive its goal."""

    __slots__ = ('_server', '_uuid', 'goal_id_bytes', 'request')

    def __init__(self, server: ActionServerCore, goal_id: GoalId, request: Any) -> None:
        self._server = server
        self._uuid: Any = None
        self.goal_id_bytes = goal_id
        self.request = request
        """The goal message that the client sent."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and other.goal_id_bytes == self.goal_id_bytes

    def __hash__(self) -> int:
        return hash(self.goal_id_bytes)

    @property
    def goal_id(self) -> Any:
        """Its unique_identifier_msgs/msg/UUID."""
        if self._uuid is None:
            from goalwire.entities.goal_ids import uuid_message

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

    def execute(self, execute_callback: Callable[[ServerGoalHandle], object] | None = None) -> None:
        """Start the execute callback, the server's own unless one is given.

        Raises RCLError for a goal that was executed before or has ended.
        """
        self._server.start_execution(self, execute_callback)

    def publish_feedback(self, feedback: Any) -> None:
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
