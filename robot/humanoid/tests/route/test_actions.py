"""What the navigator's actions read from a goal, and say of its progress."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints

from humanoid.goal_endings import End, Ending
from humanoid.route.actions import Progress, WaypointsManner
from humanoid.route.errand import Failure
from humanoid.route.goals import Refused


def goal(number_of_poses: int, *, start: int = 0, loops: int = 0) -> FollowWaypoints.Goal:
    poses = [PoseStamped() for _ in range(number_of_poses)]
    for at, pose in enumerate(poses):
        pose.pose.position.x = float(at)
    return FollowWaypoints.Goal(poses=poses, goal_index=start, number_of_loops=loops)


def progress(poses_left: int) -> Progress:
    return Progress(PoseStamped(), 1.0, 1.0, 1.0, 0, poses_left)


def test_waypoints_begin_at_the_index_and_their_loops_at_the_first() -> None:
    request, manner = goal(3, start=1, loops=1), WaypointsManner()
    assert [pose.pose.position.x for pose in manner.poses(request)] == [1.0, 2.0, 0.0, 1.0, 2.0]
    told = [manner.feedback(request, progress(left)).current_waypoint for left in (5, 4, 3, 2, 1)]
    assert told == [1, 2, 0, 1, 2]


def test_the_waypoint_that_was_not_reached_is_named() -> None:
    request = goal(3)
    ending = Ending(End.ABORTED, 'No way')
    result = WaypointsManner().result(request, progress(2), ending, Failure.NO_WAY)
    [missed] = result.missed_waypoints
    assert (missed.index, missed.goal.pose.position.x, missed.error_code) == (1, 1.0, 208)
    assert (result.error_code, result.error_msg) == (600, 'No way')
    reached = WaypointsManner().result(request, progress(1), Ending(End.SUCCEEDED, ''), Failure.NONE)
    assert (reached.missed_waypoints, reached.error_code) == ([], 0)


@pytest.mark.parametrize(
    ('request_', 'why'),
    [
        (goal(0), 'goal_index 0 is not below the number of poses, 0'),
        (goal(2, start=2), 'goal_index 2'),
        (goal(2, loops=2**32 - 1), '2 poses in 4294967296 loops are more than 100'),
    ],
    ids=['no poses', 'an index behind the last pose', 'loops without end'],
)
def test_waypoints_without_a_way_through_them_are_refused(request_: FollowWaypoints.Goal, why: str) -> None:
    with pytest.raises(Refused, match=why):
        WaypointsManner().poses(request_)
