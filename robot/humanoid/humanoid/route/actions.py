"""The actions that drive the robot to a goal: they differ only in their message types."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from geometry_msgs.msg import PoseStamped
from humanoid_interfaces.action import MoveToPosition
from nav2_msgs.action import NavigateThroughPoses, NavigateToPose

from humanoid.clock import duration_msg
from humanoid.goal_endings import Ending
from humanoid.navigation.goal_check import LONGEST
from humanoid.route.errand import Failure
from humanoid.route.goals import MAP, Refused
from humanoid.route.messages import CODES


@dataclass(frozen=True)
class Progress:
    """The progress of a drive: times in s, distances in m."""

    pose: PoseStamped  # the robot's pose in the goal's frame
    elapsed: float
    left: float
    time_left: float
    recoveries: int
    poses_left: int


class Manner(Protocol):
    """One action type: translates between its messages and the drive."""

    name: str
    type_: Any
    default_frame: str

    def poses(self, request: Any) -> Sequence[PoseStamped]:
        """Return the poses to drive through."""

    def time_allowed(self, request: Any) -> float:
        """Return how many s the drive may take. Raises Refused."""

    def feedback(self, progress: Progress) -> Any: ...

    def result(self, progress: Progress, ending: Ending, failure: Failure) -> Any: ...


class MoveManner:
    """The action MoveToPosition. A goal without a frame is in `odom`, as if there were no map."""

    name, type_, default_frame = 'move_to_position', MoveToPosition, 'odom'

    def poses(self, request: MoveToPosition.Goal) -> Sequence[PoseStamped]:
        return [request.target_pose]

    def time_allowed(self, request: MoveToPosition.Goal) -> float:
        if not 0.0 < request.timeout <= LONGEST:
            raise Refused(f'timeout {request.timeout} s is not a time of more than 0, up to {LONGEST:g} s')
        return request.timeout

    def feedback(self, progress: Progress) -> MoveToPosition.Feedback:
        return MoveToPosition.Feedback(
            current_pose=progress.pose, elapsed_time=progress.elapsed, distance_remaining=progress.left
        )

    def result(self, progress: Progress, ending: Ending, _failure: Failure) -> MoveToPosition.Result:
        return MoveToPosition.Result(final_pose=progress.pose, success=ending.success, message=ending.message)


class NavigateManner:
    """Nav2's action NavigateToPose, with one pose as its goal."""

    name, type_, default_frame = 'navigate_to_pose', NavigateToPose, MAP

    def poses(self, request: NavigateToPose.Goal) -> Sequence[PoseStamped]:
        return [request.pose]

    def time_allowed(self, _request: NavigateToPose.Goal) -> float:
        return LONGEST

    def feedback(self, progress: Progress) -> NavigateToPose.Feedback:
        return NavigateToPose.Feedback(**_nav2_feedback(progress))

    def result(self, _progress: Progress, ending: Ending, failure: Failure) -> NavigateToPose.Result:
        message = '' if ending.success else ending.message
        return NavigateToPose.Result(error_code=CODES[failure], error_msg=message)


class ThroughManner:
    """Nav2's action NavigateThroughPoses, with several poses as its goal."""

    name, type_, default_frame = 'navigate_through_poses', NavigateThroughPoses, MAP

    def poses(self, request: NavigateThroughPoses.Goal) -> Sequence[PoseStamped]:
        return list(request.poses)

    def time_allowed(self, _request: NavigateThroughPoses.Goal) -> float:
        return LONGEST

    def feedback(self, progress: Progress) -> NavigateThroughPoses.Feedback:
        return NavigateThroughPoses.Feedback(
            number_of_poses_remaining=progress.poses_left, **_nav2_feedback(progress)
        )

    def result(self, _progress: Progress, ending: Ending, failure: Failure) -> NavigateThroughPoses.Result:
        message = '' if ending.success else ending.message
        return NavigateThroughPoses.Result(error_code=CODES[failure], error_msg=message)


def _nav2_feedback(progress: Progress) -> dict[str, Any]:
    return {
        'current_pose': progress.pose,
        'navigation_time': duration_msg(progress.elapsed),
        'estimated_time_remaining': duration_msg(progress.time_left),
        'number_of_recoveries': progress.recoveries,
        'distance_remaining': progress.left,
    }


MANNERS: Sequence[Manner] = (MoveManner(), NavigateManner(), ThroughManner())
