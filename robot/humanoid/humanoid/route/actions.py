"""The actions that drive the robot to a goal: they differ only in their message types."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from geometry_msgs.msg import PoseStamped
from humanoid_interfaces.action import MoveToPosition
from nav2_msgs.action import FollowWaypoints, NavigateThroughPoses, NavigateToPose
from nav2_msgs.msg import MissedWaypoint

from humanoid.clock import duration_msg
from humanoid.goal_endings import Ending
from humanoid.navigation.goal_check import LONGEST
from humanoid.route.errand import Failure
from humanoid.route.goals import MAP, MOST_POSES, Refused
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
    stops_at_each: bool  # False: it passes all poses but the last one by

    def poses(self, request: Any) -> Sequence[PoseStamped]:
        """Return the poses to drive through."""

    def time_allowed(self, request: Any) -> float:
        """Return how many s the drive may take. Raises Refused."""

    def feedback(self, request: Any, progress: Progress) -> Any: ...

    def result(self, request: Any, progress: Progress, ending: Ending, failure: Failure) -> Any: ...


class MoveManner:
    """The action MoveToPosition. A goal without a frame is in `odom`, as if there were no map."""

    name, type_, default_frame = 'move_to_position', MoveToPosition, 'odom'
    stops_at_each = False

    def poses(self, request: MoveToPosition.Goal) -> Sequence[PoseStamped]:
        return [request.target_pose]

    def time_allowed(self, request: MoveToPosition.Goal) -> float:
        if not 0.0 < request.timeout <= LONGEST:
            raise Refused(f'timeout {request.timeout} s is not a time of more than 0, up to {LONGEST:g} s')
        return request.timeout

    def feedback(self, _request: MoveToPosition.Goal, progress: Progress) -> MoveToPosition.Feedback:
        return MoveToPosition.Feedback(
            current_pose=progress.pose, elapsed_time=progress.elapsed, distance_remaining=progress.left
        )

    def result(
        self, _request: MoveToPosition.Goal, progress: Progress, ending: Ending, _failure: Failure
    ) -> MoveToPosition.Result:
        return MoveToPosition.Result(final_pose=progress.pose, success=ending.success, message=ending.message)


class NavigateManner:
    """Nav2's action NavigateToPose, with one pose as its goal."""

    name, type_, default_frame = 'navigate_to_pose', NavigateToPose, MAP
    stops_at_each = False

    def poses(self, request: NavigateToPose.Goal) -> Sequence[PoseStamped]:
        return [request.pose]

    def time_allowed(self, _request: NavigateToPose.Goal) -> float:
        return LONGEST

    def feedback(self, _request: NavigateToPose.Goal, progress: Progress) -> NavigateToPose.Feedback:
        return NavigateToPose.Feedback(**_nav2_feedback(progress))

    def result(
        self, _request: NavigateToPose.Goal, _progress: Progress, ending: Ending, failure: Failure
    ) -> NavigateToPose.Result:
        message = '' if ending.success else ending.message
        return NavigateToPose.Result(error_code=CODES[failure], error_msg=message)


class ThroughManner:
    """Nav2's action NavigateThroughPoses, with several poses as its goal."""

    name, type_, default_frame = 'navigate_through_poses', NavigateThroughPoses, MAP
    stops_at_each = False

    def poses(self, request: NavigateThroughPoses.Goal) -> Sequence[PoseStamped]:
        return list(request.poses)

    def time_allowed(self, _request: NavigateThroughPoses.Goal) -> float:
        return LONGEST

    def feedback(
        self, _request: NavigateThroughPoses.Goal, progress: Progress
    ) -> NavigateThroughPoses.Feedback:
        return NavigateThroughPoses.Feedback(
            number_of_poses_remaining=progress.poses_left, **_nav2_feedback(progress)
        )

    def result(
        self, _request: NavigateThroughPoses.Goal, _progress: Progress, ending: Ending, failure: Failure
    ) -> NavigateThroughPoses.Result:
        message = '' if ending.success else ending.message
        return NavigateThroughPoses.Result(error_code=CODES[failure], error_msg=message)


class WaypointsManner:
    """Nav2's action FollowWaypoints: the robot stops at each pose, in each of the loops.

    No task is done at a waypoint, and the first one that cannot be reached ends the goal.
    """

    name, type_, default_frame = 'follow_waypoints', FollowWaypoints, MAP
    stops_at_each = True

    def poses(self, request: FollowWaypoints.Goal) -> Sequence[PoseStamped]:
        poses, start, loops = list(request.poses), request.goal_index, request.number_of_loops
        if start >= len(poses):
            raise Refused(f'goal_index {start} is not below the number of poses, {len(poses)}')
        if len(poses) * (loops + 1) > MOST_POSES:
            raise Refused(f'{len(poses)} poses in {loops + 1} loops are more than {MOST_POSES}')
        return poses[start:] + poses * loops

    def time_allowed(self, _request: FollowWaypoints.Goal) -> float:
        return LONGEST

    def feedback(self, request: FollowWaypoints.Goal, progress: Progress) -> FollowWaypoints.Feedback:
        return FollowWaypoints.Feedback(current_waypoint=_waypoint(request, progress))

    def result(
        self, request: FollowWaypoints.Goal, progress: Progress, ending: Ending, failure: Failure
    ) -> FollowWaypoints.Result:
        result = FollowWaypoints.Result()
        if not ending.success:
            at = _waypoint(request, progress)
            missed = MissedWaypoint(index=at, goal=request.poses[at], error_code=CODES[failure])
            result.missed_waypoints = [missed]
            result.error_code, result.error_msg = FollowWaypoints.Result.UNKNOWN, ending.message
        return result


def _waypoint(request: FollowWaypoints.Goal, progress: Progress) -> int:
    """Return the number of the waypoint that the robot goes to."""
    return -progress.poses_left % len(request.poses)


def _nav2_feedback(progress: Progress) -> dict[str, Any]:
    return {
        'current_pose': progress.pose,
        'navigation_time': duration_msg(progress.elapsed),
        'estimated_time_remaining': duration_msg(progress.time_left),
        'number_of_recoveries': progress.recoveries,
        'distance_remaining': progress.left,
    }


MANNERS: Sequence[Manner] = (MoveManner(), NavigateManner(), ThroughManner(), WaypointsManner())
