"""rclpy.action.client: sends goals to an action server, follows them, and cancels them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, overload

from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.actions.client_goal_handle import ClientGoalHandle
from goalwire.entities.actions.types import (
    ActionClass,
    FeedbackMessage,
    FeedbackMessageT,
    FeedbackT,
    GoalT,
    ResultResponse,
    ResultT,
)
from goalwire.entities.type_support import action_support
from goalwire.execution.callback_groups import check_group
from goalwire.execution.wait_sets.waitable import EventQueueWaitable
from goalwire.rules.goals.cancel_requests import read_stamp
from goalwire.rules.goals.ids import NO_ID
from rclpy._reexports import reexport
from rclpy.action._making import action_qos, check_node, refusing_bad_names
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile, qos_profile_action_status_default, qos_profile_services_default
from rclpy.task import Future
from rclpy.waitable import NumberOfEntities

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time as StampMessage
    from unique_identifier_msgs.msg import UUID

    from goalwire.execution.wait_sets.waitable import WaitSet
    from rclpy.impl.base_node import BaseNode
    from rclpy.time import Time

__all__ = ['ActionClient', 'ClientGoalHandle', 'FeedbackMessage', 'ResultResponse']


_FEEDBACK_QOS = QoSProfile(depth=10)


class ActionClient(ActionClientCore, EventQueueWaitable, Generic[GoalT, ResultT, FeedbackT]):
    """Calls one action."""

    def __init__(
        self,
        node: BaseNode,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_sub_qos_profile: QoSProfile = _FEEDBACK_QOS,
        status_sub_qos_profile: QoSProfile = qos_profile_action_status_default,
    ) -> None:
        """Construct the client; raises ValueError for a bad action name."""
        check_node(node, 'ActionClient')
        qos = action_qos(
            goal_service_qos_profile,
            result_service_qos_profile,
            cancel_service_qos_profile,
            feedback_sub_qos_profile,
            status_sub_qos_profile,
        )
        group = node.default_callback_group if callback_group is None else check_group(callback_group)
        support = action_support(action_type, action_name, call='ActionClient(node, {}, {})')
        EventQueueWaitable.__init__(self, group)
        with refusing_bad_names('client', action_name):
            ActionClientCore.__init__(self, node.handle, support, action_name, group, qos)
        # Decoders are made now: goal ids need numpy, whose import would delay the first goal by 80 ms.
        _ = support.feedback.decode, support.send_goal.decode_response, support.get_result.decode_response
        self._node = node
        self._action_type = action_type
        node.add_waitable(self)

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of this client's entities: three service clients, two subscriptions."""
        return NumberOfEntities(num_subs=2, num_clients=3)

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the subscriptions for status and feedback to `wait_set`; replies need no executor."""
        for event_queue in self.event_queues():
            wait_set.add_subscription(event_queue)

    @overload
    def send_goal_async(
        self,
        goal: GoalT,
        feedback_callback: Callable[[FeedbackMessage[FeedbackT]], object] | None = None,
        goal_uuid: UUID | None = None,
    ) -> Future[ClientGoalHandle[GoalT, ResultT, FeedbackT]]: ...
    @overload
    def send_goal_async(
        self,
        goal: GoalT,
        feedback_callback: Callable[[FeedbackMessageT], object],
        goal_uuid: UUID | None = None,
    ) -> Future[ClientGoalHandle[GoalT, ResultT, FeedbackT]]: ...
    def send_goal_async(
        self,
        goal: GoalT,
        feedback_callback: Callable[[Any], object] | None = None,
        goal_uuid: UUID | None = None,
    ) -> Future[ClientGoalHandle[GoalT, ResultT, FeedbackT]]:
        """Send a goal; the future gives its ClientGoalHandle, accepted or not.

        `feedback_callback` gets the action's FeedbackMessage. Raises TypeError unless `goal` is the action's
        Goal.
        """
        return self.send(goal, feedback_callback, goal_uuid)

    def send_goal(self, goal: GoalT, **kwargs: Any) -> ResultResponse[ResultT] | None:
        """Send a goal, wait for its end, and return the action's GetResult response: the status and the
        result.

        Takes the keyword arguments of send_goal_async. Raises ShutDownError if the context ends before
        that, InvalidHandle if the client is destroyed.
        """
        handle = self.blocking.wait_for(lambda: self.send_goal_async(goal, **kwargs))
        return None if handle is None else handle.get_result()

    def cancel_all_goals_async(self) -> Future[CancelGoal.Response]:
        """Ask the server to cancel every goal, including other clients' goals.

        The returned future gives the goals that the server cancels.
        """
        return self.cancel_goal(NO_ID)

    def cancel_goals_before_async(self, stamp: Time | StampMessage) -> Future[CancelGoal.Response]:
        """Ask the server to cancel the goals that it accepted at or before a time of its clock.

        Raises TypeError for anything but a time, ValueError for a time not above 0, which would mean all
        goals.
        """
        return self.cancel_goal(NO_ID, read_stamp(stamp))

    def cancel_all_goals(self) -> CancelGoal.Response | None:
        """Do as `cancel_all_goals_async`, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.blocking.wait_for(self.cancel_all_goals_async)
        return answer

    def cancel_goals_before(self, stamp: Time | StampMessage) -> CancelGoal.Response | None:
        """Do as `cancel_goals_before_async`, and wait; raises as ClientGoalHandle.cancel_goal does."""
        answer: CancelGoal.Response | None = self.blocking.wait_for(
            lambda: self.cancel_goals_before_async(stamp)
        )
        return answer

    # the following are private names of rclpy that tf2_ros and smach_ros call

    def _get_result(
        self, goal_handle: ClientGoalHandle[GoalT, ResultT, FeedbackT]
    ) -> ResultResponse[ResultT] | None:
        return _check(goal_handle).get_result()

    def _get_result_async(
        self, goal_handle: ClientGoalHandle[GoalT, ResultT, FeedbackT]
    ) -> Future[ResultResponse[ResultT]]:
        return _check(goal_handle).get_result_async()

    def _cancel_goal(
        self, goal_handle: ClientGoalHandle[GoalT, ResultT, FeedbackT]
    ) -> CancelGoal.Response | None:
        return _check(goal_handle).cancel_goal()

    def _cancel_goal_async(
        self, goal_handle: ClientGoalHandle[GoalT, ResultT, FeedbackT]
    ) -> Future[CancelGoal.Response]:
        return _check(goal_handle).cancel_goal_async()

    def server_is_ready(self) -> bool:
        """True while there is a server of this action."""
        return self.server_is_there()

    def destroy(self) -> None:
        """Remove the client from the graph. Its pending futures are never completed. Idempotent."""
        if not self.destroyed:
            self._node.remove_waitable(self)
        ActionClientCore.destroy(self)


def _check(
    handle: ClientGoalHandle[GoalT, ResultT, FeedbackT],
) -> ClientGoalHandle[GoalT, ResultT, FeedbackT]:
    if not isinstance(handle, ClientGoalHandle):
        raise TypeError(f'Expected type ClientGoalHandle but received {type(handle)}')
    return handle


reexport(__name__)
