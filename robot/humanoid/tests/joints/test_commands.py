from __future__ import annotations

import math

import pytest

from humanoid.joints.commands import CommandRefused, Point, Waypoint, plan
from humanoid.model import JOINT_BY_NAME

SHOULDER, ELBOW = 'left_arm_shoulder', 'left_arm_elbow'


def test_a_trajectory_is_sorted_by_joint() -> None:
    planned = plan([SHOULDER, ELBOW], [Point(1.0, [0.1, 0.2]), Point(2.0, [0.3, 0.4])], JOINT_BY_NAME)
    assert planned == {
        SHOULDER: [Waypoint(1.0, 0.1), Waypoint(2.0, 0.3)],
        ELBOW: [Waypoint(1.0, 0.2), Waypoint(2.0, 0.4)],
    }


def test_velocities_and_accelerations_go_along() -> None:
    points = [Point(1.0, [0.1], [0.2], [0.3]), Point(2.0, [0.3], [0.0])]
    assert plan([SHOULDER], points, JOINT_BY_NAME) == {
        SHOULDER: [Waypoint(1.0, 0.1, 0.2, 0.3), Waypoint(2.0, 0.3, 0.0)]
    }


def test_a_trajectory_without_points_holds_its_joints() -> None:
    assert plan([SHOULDER], [], JOINT_BY_NAME) == {SHOULDER: []}


@pytest.mark.parametrize(
    ('names', 'points', 'complaint'),
    [
        (['tail'], [(1.0, [0.0])], "unknown joint 'tail'"),
        ([SHOULDER, SHOULDER], [(1.0, [0.0, 0.0])], 'named twice'),
        ([SHOULDER], [(1.0, [0.0, 0.0])], '2 positions for 1 joints'),
        ([SHOULDER], [(1.0, [])], '0 positions for 1 joints'),
        ([SHOULDER], [(1.0, [0.0]), (1.0, [0.1])], 'grow by point'),
        ([SHOULDER], [(-0.1, [0.0])], '0 or more'),
        ([SHOULDER], [(math.nan, [0.0])], 'time_from_start'),
        ([SHOULDER], [(1.0, [2.91])], 'cannot go to 2.91 rad; its limits are -2.9 to 2.9'),
        ([SHOULDER], [(1.0, [math.nan])], 'cannot go to nan'),
        ([ELBOW], [(1.0, [-0.01])], 'left_arm_elbow cannot go to -0.01 rad'),
        ([ELBOW], [(1.0, [0.1], [0.1, 0.2])], 'a point has 2 velocities for 1 joints'),
        ([ELBOW], [(1.0, [0.1], [0.0], [0.1, 0.2])], 'a point has 2 accelerations for 1 joints'),
        (
            [ELBOW],
            [(1.0, [0.1], [-2.6]), (2.0, [0.2])],
            'a point with -2.6 rad/s; its limit is 2.5',
        ),
        ([ELBOW], [(1.0, [0.1], [math.nan])], 'cannot pass a point with nan rad/s'),
        ([ELBOW], [(1.0, [0.1], [0.5])], 'would end with 0.5 rad/s: the last point is a rest'),
        (
            [ELBOW],
            [(1.0, [0.1], [0.0], [math.inf])],
            'the acceleration of left_arm_elbow is inf',
        ),
        (
            [ELBOW],
            [(1.0, [0.1], [0.0], [1e308]), (2.0, [0.2], [0.0], [-1e308])],
            'not a number up to 1e+06',
        ),
    ],
)
def test_a_command_that_the_joints_cannot_follow_is_refused(
    names: list[str], points: list[tuple[float, *tuple[list[float], ...]]], complaint: str
) -> None:
    with pytest.raises(CommandRefused) as refused:
        plan(names, [Point(*point) for point in points], JOINT_BY_NAME)
    assert complaint in str(refused.value)


def test_the_limits_themselves_are_within_reach() -> None:
    joint = JOINT_BY_NAME[ELBOW]
    assert plan([ELBOW], [Point(1.0, [joint.lower]), Point(2.0, [joint.upper])], JOINT_BY_NAME)
