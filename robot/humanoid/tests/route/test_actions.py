"""The navigator's actions: reading their goals, and reporting progress."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import AssistedTeleop, FollowPath, FollowWaypoints
from nav_msgs.msg import Path
from std_msgs.msg import Header

from humanoid.goal_endings import End, Ending
from humanoid.route.actions import PathManner, Progress, TeleopManner, WaypointsManner
from humanoid.route.goals import Refused
from humanoid.route.task import Failure


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


def test_a_path_counts_in_its_own_frame_and_if_it_has_none_in_those_of_its_poses() -> None:
    path = Path(poses=[PoseStamped(header=Header(frame_id='odom')), PoseStamped()])
    assert frames(PathManner().poses(FollowPath.Goal(path=path))) == ['odom', '']
    path.header.frame_id = 'base_link'
    assert frames(PathManner().poses(FollowPath.Goal(path=path))) == ['base_link', 'base_link']


def frames(poses: Sequence[PoseStamped]) -> list[str]:
    return [pose.header.frame_id for pose in poses]


@pytest.mark.parametrize('field', ['controller_id', 'goal_checker_id', 'progress_checker_id'])
def test_controllers_and_checkers_that_are_not_there_are_refused(field: str) -> None:
    request = FollowPath.Goal()
    setattr(request, field, 'mine')
    with pytest.raises(Refused, match=f"{field} 'mine' is not there; leave it empty or write '"):
        PathManner().check(request, None, None, [])


@pytest.mark.parametrize(
    ('ending', 'failure', 'path_code', 'teleop_code'),
    [
        (Ending(End.SUCCEEDED, 'There'), Failure.NONE, 0, 0),
        (Ending(End.CANCELED, 'Goal canceled'), Failure.NONE, 0, 0),
        (Ending(End.ABORTED, 'Emergency stop'), Failure.NONE, 100, 730),
        (Ending(End.ABORTED, 'Lost'), Failure.LOST, 102, 732),
        (Ending(End.ABORTED, 'Blocked'), Failure.BLOCKED, 104, 730),
        (Ending(End.ABORTED, 'Stuck'), Failure.STUCK, 105, 730),
        (Ending(End.ABORTED, 'Late'), Failure.LATE, 100, 731),
    ],
)
def test_results_have_the_error_codes_of_nav2(
    ending: Ending, failure: Failure, path_code: int, teleop_code: int
) -> None:
    path = PathManner().result(FollowPath.Goal(), progress(0), ending, failure)
    teleop = TeleopManner().result(AssistedTeleop.Goal(), progress(0), ending, failure)
    message = '' if ending.success else ending.message
    assert (path.error_code, path.error_msg) == (path_code, message)
    assert (teleop.error_code, teleop.error_msg) == (teleop_code, message)
    assert teleop.total_elapsed_time.sec == 1
