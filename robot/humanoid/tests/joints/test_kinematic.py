from __future__ import annotations

import pytest

from humanoid.joints.commands import Waypoint
from humanoid.joints.kinematic import KinematicJoints, Path
from humanoid.model import JOINTS, JointSpec

TICK = 0.02
SLOW = JointSpec('slow', home=0.0, lower=-1.0, upper=1.0, max_velocity=0.5, friction=2.0)


def run_until(joints: KinematicJoints, now: float, end: float) -> float:
    while now < end - TICK / 2:
        now += TICK
        joints.update(now)
    return now


def slow_joints() -> KinematicJoints:
    return KinematicJoints({'slow': SLOW}, now=10.0)


def test_joints_start_at_home_and_at_rest() -> None:
    joints = KinematicJoints()
    joints.update(1.0)
    for spec in JOINTS:
        sample = joints.read(spec.name)
        assert (sample.position, sample.velocity, sample.effort) == (spec.home, 0.0, 0.0)
        assert not sample.is_moving


def test_a_joint_is_at_its_waypoint_in_time_and_on_a_straight_line_before() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(2.0, 0.4)]}, start=10.0)
    run_until(joints, 10.0, 11.0)
    assert joints.read('slow').position == pytest.approx(0.2, abs=1e-6)
    assert joints.read('slow').velocity == pytest.approx(0.2)
    assert joints.read('slow').effort == pytest.approx(0.4)
    assert joints.read('slow').is_moving
    run_until(joints, 11.0, 12.1)
    assert joints.read('slow').position == pytest.approx(0.4)
    assert not joints.read('slow').is_moving


def test_waypoints_are_passed_in_order() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(1.0, 0.2), Waypoint(2.0, -0.2)]}, start=10.0)
    run_until(joints, 10.0, 11.0)
    assert joints.read('slow').position == pytest.approx(0.2, abs=1e-6)
    run_until(joints, 11.0, 12.1)
    assert joints.read('slow').position == pytest.approx(-0.2)


def test_a_hurried_command_is_followed_no_faster_than_the_velocity_limit() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(0.1, 1.0)]}, start=10.0)
    now = 10.0
    for _ in range(60):
        now += TICK
        joints.update(now)
        assert abs(joints.read('slow').velocity) <= SLOW.max_velocity + 1e-9
    assert joints.read('slow').position == pytest.approx(0.6)


def test_an_update_after_a_long_gap_does_not_jump_further_than_the_gap_allows() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(0.1, 1.0)]}, start=10.0)
    joints.update(11.0)
    assert joints.read('slow').position == pytest.approx(0.5)


def test_a_joint_never_passes_its_stop() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(1.0, 5.0)]}, start=10.0)
    run_until(joints, 10.0, 20.0)
    assert joints.read('slow').position == SLOW.upper


def test_a_plan_without_waypoints_stops_the_joint_where_it_is() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(2.0, 0.8)]}, start=10.0)
    now = run_until(joints, 10.0, 11.0)
    there = joints.read('slow').position
    joints.follow({'slow': []}, start=now)
    joints.update(now + TICK)
    assert joints.read('slow').position == there
    assert joints.read('slow').velocity == 0.0


def test_a_newer_plan_replaces_the_older_one_of_its_joints_alone() -> None:
    other = JointSpec('other', 0.0, -1.0, 1.0, 1.0, 1.0)
    joints = KinematicJoints({'slow': SLOW, 'other': other}, now=0.0)
    joints.follow({'slow': [Waypoint(2.0, 0.4)], 'other': [Waypoint(2.0, 0.4)]}, start=0.0)
    now = run_until(joints, 0.0, 1.0)
    joints.follow({'slow': [Waypoint(1.0, 0.0)]}, start=now)
    run_until(joints, now, 2.1)
    assert joints.read('slow').position == pytest.approx(0.0)
    assert joints.read('other').position == pytest.approx(0.4)


def test_a_clock_set_back_moves_nothing() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(1.0, 0.4)]}, start=10.0)
    joints.update(10.5)
    before = joints.read('slow')
    joints.update(9.0)
    assert joints.read('slow') == before


REST = {'velocity': 0.0}


@pytest.mark.parametrize(
    ('first', 'last', 'expected'),
    [  # position and velocity a quarter and half of the way through 2 s and 0.8 rad
        ({}, {}, [(0.3, 0.4), (0.5, 0.4)]),
        (REST, {}, [(0.3, 0.4), (0.5, 0.4)]),
        (REST, REST, [(0.1 + 0.8 * 5 / 32, 0.4 * 9 / 8), (0.5, 0.4 * 3 / 2)]),
        (
            {**REST, 'acceleration': 0.0},
            {**REST, 'acceleration': 0.0},
            [(0.1 + 0.8 * 53 / 512, 0.4 * 135 / 128), (0.5, 0.4 * 15 / 8)],
        ),
    ],
)
def test_between_two_points_it_is_a_line_a_cubic_or_a_quintic(
    first: dict[str, float], last: dict[str, float], expected: list[tuple[float, float]]
) -> None:
    path = Path(5.0, [Waypoint(1.0, 0.1, **first), Waypoint(3.0, 0.9, **last)])
    assert path.at(5.5) == (0.1, 0.0)
    assert path.at(6.5) == pytest.approx(expected[0])
    assert path.at(7.0) == pytest.approx(expected[1])
    assert path.at(8.0) == (0.9, 0.0)


def test_points_are_passed_with_their_velocity_and_acceleration() -> None:
    points = [Waypoint(1.0, 0.1, 0.3, -0.2), Waypoint(2.5, 0.4, -0.1, 0.6), Waypoint(4.0, 0.2, 0.2, 0.0)]
    path, step = Path(0.0, points), 1e-4
    for point in points[:-1]:
        assert path.at(point.time) == pytest.approx((point.position, point.velocity))
        speeds = [path.at(point.time + number * step)[1] for number in (0, 1)]
        assert (speeds[1] - speeds[0]) / step == pytest.approx(point.acceleration, abs=1e-3)
    assert path.at(4.0 - 1e-9) == pytest.approx((0.2, 0.2), abs=1e-6)


def test_a_path_begins_with_the_velocity_that_the_joint_has() -> None:
    joints = slow_joints()
    joints.follow({'slow': [Waypoint(2.0, 0.8)]}, start=10.0)
    now = run_until(joints, 10.0, 11.0)
    joints.follow({'slow': [Waypoint(1.0, 0.6, 0.0)]}, start=now)
    joints.update(now + TICK)
    assert joints.read('slow').velocity == pytest.approx(0.4, abs=0.02), 'it goes on without a jerk'
    run_until(joints, now + TICK, now + 1.1)
    assert joints.read('slow').position == pytest.approx(0.6)
