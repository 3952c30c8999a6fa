"""The actions that drive the robot: what each reads from its goals, and what it tells of their progress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from geometry_msgs.msg import PoseStamped
from humanoid_interfaces.action import MoveToPosition
from nav2_msgs.action import (
    AssistedTeleop,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
)
from nav2_msgs.msg import MissedWaypoint

from humanoid.clock import duration_msg, seconds
from humanoid.goal_endings import End, Ending
from humanoid.navigation.base import Pose2D
from humanoid.navigation.goal_check import LONGEST
from humanoid.route.costmap import Costmap
from humanoid.route.errand import Errand
from humanoid.route.goals import MAP, MOST_POSES, Refused, check, check_id, check_path, check_place, poses_of
from humanoid.route.messages import CODES, PATH_CODES, TELEOP_CODES
from humanoid.route.path_errand import PathErrand
from humanoid.route.task import Failure, Task
from humanoid.route.teleop_errand import TeleopErrand

ONLY_ONES = {
    'controller_id': 'FollowPath',
    'goal_checker_id': 'general_goal_checker',
    'progress_checker_id': 'progress_checker',
}
"""The names that Nav2's own configuration has for them."""


@dataclass(frozen=True)
class Progress:
    """The progress of a drive: times in s, distances in m, `speed` in m/s as the base was asked for it."""

    pose: PoseStamped  # the robot's pose in the goal's frame
    elapsed: float
    left: float
    time_left: float
    recoveries: int
    poses_left: int
    speed: float = 0.0


class Manner(Protocol):
    """One action type: translates between its messages and the drive."""

    name: str
    type_: Any
    default_frame: str

    def poses(self, request: Any) -> Sequence[PoseStamped]:
        """Return the poses to drive through; none if the goal has no poses. Raises Refused."""

    def time_allowed(self, request: Any) -> float:
        """Return how many s the drive may take. Raises Refused."""

    def check(
        self, request: Any, costmap: Costmap | None, pose: Pose2D | None, targets: Sequence[Pose2D]
    ) -> None:
        """Raise Refused unless the robot at `pose` can do it. `targets`: the goal's poses on the map."""

    def set_out(self, request: Any, targets: Sequence[Pose2D], now: float) -> Task:
        """Return the task that carries an accepted goal out. `targets`: the goal's poses on the map."""

    def feedback(self, request: Any, progress: Progress) -> Any: ...

    def result(self, request: Any, progress: Progress, ending: Ending, failure: Failure) -> Any: ...


class ToPoses:
    """The common part of the actions that plan their way through the poses of a goal."""

    stops_at_each = False  # it passes all poses but the last one by

    def time_allowed(self, _request: Any) -> float:
        return LONGEST

    def check(
        self, _request: Any, costmap: Costmap | None, pose: Pose2D | None, targets: Sequence[Pose2D]
    ) -> None:
        check(costmap, pose, targets)

    def set_out(self, _request: Any, targets: Sequence[Pose2D], now: float) -> Task:
        return Errand(targets, now, stops_at_each=self.stops_at_each)


class MoveManner(ToPoses):
    """The action MoveToPosition. A goal without a frame is in `odom`, as if there were no map."""

    name, type_, default_frame = 'move_to_position', MoveToPosition, 'odom'

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


class NavigateManner(ToPoses):
    """Nav2's action NavigateToPose, with one pose as its goal."""

    name, type_, default_frame = 'navigate_to_pose', NavigateToPose, MAP

    def poses(self, request: NavigateToPose.Goal) -> Sequence[PoseStamped]:
        return [request.pose]

    def feedback(self, _request: NavigateToPose.Goal, progress: Progress) -> NavigateToPose.Feedback:
        return NavigateToPose.Feedback(**_nav2_feedback(progress))

    def result(
        self, _request: NavigateToPose.Goal, _progress: Progress, ending: Ending, failure: Failure
    ) -> NavigateToPose.Result:
        message = '' if ending.success else ending.message
        return NavigateToPose.Result(error_code=CODES[failure], error_msg=message)


class ThroughManner(ToPoses):
    """Nav2's action NavigateThroughPoses, with several poses as its goal."""

    name, type_, default_frame = 'navigate_through_poses', NavigateThroughPoses, MAP

    def poses(self, request: NavigateThroughPoses.Goal) -> Sequence[PoseStamped]:
        return list(request.poses)

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


class WaypointsManner(ToPoses):
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


class PathManner:
    """Nav2's action FollowPath: the robot follows the line through the path's poses.

    Nav2 lets a goal choose among configured controllers and checkers; here there is one of each.
    """

    name, type_, default_frame = 'follow_path', FollowPath, MAP

    def poses(self, request: FollowPath.Goal) -> Sequence[PoseStamped]:
        return poses_of(request.path)

    def time_allowed(self, _request: FollowPath.Goal) -> float:
        return LONGEST

    def check(
        self,
        request: FollowPath.Goal,
        costmap: Costmap | None,
        pose: Pose2D | None,
        targets: Sequence[Pose2D],
    ) -> None:
        for field, only in ONLY_ONES.items():
            check_id(field, getattr(request, field), only)
        check_path(costmap, pose, targets)

    def set_out(self, _request: FollowPath.Goal, targets: Sequence[Pose2D], now: float) -> Task:
        return PathErrand(targets, now)

    def feedback(self, _request: FollowPath.Goal, progress: Progress) -> FollowPath.Feedback:
        return FollowPath.Feedback(distance_to_goal=progress.left, speed=progress.speed)

    def result(
        self, _request: FollowPath.Goal, _progress: Progress, ending: Ending, failure: Failure
    ) -> FollowPath.Result:
        result = FollowPath.Result()
        if not ending.success:
            result.error_msg = ending.message
        if ending.end is End.ABORTED:
            result.error_code = PATH_CODES.get(failure, FollowPath.Result.UNKNOWN)
        return result


class TeleopManner:
    """Nav2's action AssistedTeleop: somebody drives the robot by `cmd_vel_teleop`."""

    name, type_, default_frame = 'assisted_teleop', AssistedTeleop, MAP

    def poses(self, _request: AssistedTeleop.Goal) -> Sequence[PoseStamped]:
        return ()

    def time_allowed(self, _request: AssistedTeleop.Goal) -> float:
        return math.inf  # its task watches the time itself, as that has an error code of its own

    def check(
        self,
        _request: AssistedTeleop.Goal,
        costmap: Costmap | None,
        pose: Pose2D | None,
        _targets: Sequence[Pose2D],
    ) -> None:
        check_place(costmap, pose)

    def set_out(self, request: AssistedTeleop.Goal, _targets: Sequence[Pose2D], now: float) -> Task:
        return TeleopErrand(seconds(request.time_allowance), now)

    def feedback(self, _request: AssistedTeleop.Goal, progress: Progress) -> AssistedTeleop.Feedback:
        return AssistedTeleop.Feedback(current_teleop_duration=duration_msg(progress.elapsed))

    def result(
        self, _request: AssistedTeleop.Goal, progress: Progress, ending: Ending, failure: Failure
    ) -> AssistedTeleop.Result:
        result = AssistedTeleop.Result(total_elapsed_time=duration_msg(progress.elapsed))
        if not ending.success:
            result.error_msg = ending.message
        if ending.end is End.ABORTED:
            result.error_code = TELEOP_CODES.get(failure, AssistedTeleop.Result.UNKNOWN)
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


MANNERS: Sequence[Manner] = (
    MoveManner(),
    NavigateManner(),
    ThroughManner(),
    WaypointsManner(),
    PathManner(),
    TeleopManner(),
)
