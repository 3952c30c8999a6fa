"""rclpy.action.client: sends goals, follows them, cancels them."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

from goalwire.entities.action_client import ActionClientCore
from goalwire.entities.action_endpoints import ActionQoS
from goalwire.entities.client_goal import ClientGoalHandle
from goalwire.entities.exceptions import NameValidationException
from goalwire.entities.type_support import action_support
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.node import Node

__all__ = ['ActionClient', 'ClientGoalHandle']

ActT = TypeVar('ActT')

_FEEDBACK_QOS = QoSProfile(depth=10)


class ActionClient(ActionClientCore, Generic[ActT]):
    """Calls one action."""

    def __init__(
        self,
        node: Node,
        action_type: type[ActT],
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_sub_qos_profile: QoSProfile = _FEEDBACK_QOS,
        status_sub_qos_profile: QoSProfile = qos_profile_action_status_default,
    ) -> None:
        """Raises ValueError for a bad name."""
        qos = ActionQoS(
            goal_service_qos_profile.to_core(),
            result_service_qos_profile.to_core(),
            cancel_service_qos_profile.to_core(),
            feedback_sub_qos_profile.to_core(),
            status_sub_qos_profile.to_core(),
        )
        group = callback_group or node.default_callback_group
        support = action_support(action_type)
        try:
            super().__init__(node.core, support, action_name, group, qos)
        except NameValidationException as error:
            raise ValueError(
                f"Failed to create action client due to invalid topic name '{action_name}' : {error}"
            ) from None
        self._node = node
        self._action_type = action_type
        self.callback_group = group
        group.add_entity(self)
        node.add_waitable(self)

    def send_goal_async(
        self,
        goal: Any,
        feedback_callback: Callable[[Any], object] | None = None,
        goal_uuid: Any = None,
    ) -> Future[ClientGoalHandle]:
        """Send a goal; the future gives its ClientGoalHandle, accepted or not.

        `feedback_callback` gets the action's FeedbackMessage. Raises TypeError for another type than the
        action's Goal.
        """
        return self.send(goal, feedback_callback, goal_uuid)

    def send_goal(self, goal: Any, **kwargs: Any) -> Any:
        """Send a goal, wait for its end and return status and result (the action's GetResult response).

        Takes the keyword arguments of send_goal_async.
        """
        handle = self.wait_for(lambda: self.send_goal_async(goal, **kwargs))
        return None if handle is None else handle.get_result()

    def server_is_ready(self) -> bool:
        """True while there is a server."""
        return self.server_is_there()

    def destroy(self) -> None:
        """Undeclare; futures that are pending stay so. Idempotent."""
        if not self.destroyed:
            self._node.remove_waitable(self)
        super().destroy()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()
