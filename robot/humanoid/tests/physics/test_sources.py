"""The joints and the base in physics, behind the same seams as the kinematic ones."""

from __future__ import annotations

import math

import pytest

from humanoid.joints.commands import CommandRefused, Waypoint
from humanoid.joints.source import JointSource
from humanoid.model import JOINT_BY_NAME
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.physics.base import BACKWARDS, SIDEWAYS, TURNED_WITHIN, WALKS, WITHIN, PhysicsBase
from humanoid.physics.joints import PhysicsJoints
from humanoid.physics.world import TICK, World
from humanoid.walking.gait import SHIFT, SWING

BEGAN = 1000.0  # s of the node's clock, when the world was made
ARM = 'left_arm_shoulder'


@pytest.fixture
def joints(body: World) -> PhysicsJoints:
    return PhysicsJoints(body, JOINT_BY_NAME, now=BEGAN)


def ticks(body: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        body.tick()


def test_it_is_a_source_of_all_the_robots_joints(joints: PhysicsJoints) -> None:
    source: JointSource = joints
    assert source.joints is JOINT_BY_NAME
    for name in source.joints:
        assert not source.read(name).is_moving
    assert source.read(ARM).position == pytest.approx(0.5, abs=0.01)


def test_a_trajectory_is_followed_in_the_nodes_time(body: World, joints: PhysicsJoints) -> None:
    joints.follow({ARM: [Waypoint(1.0, 1.3), Waypoint(2.0, 0.9)]}, start=BEGAN + 0.5)
    ticks(body, 0.5)
    assert joints.read(ARM).position == pytest.approx(0.5, abs=0.02)
    ticks(body, 0.5)
    assert joints.read(ARM).position == pytest.approx(0.9, abs=0.03)
    assert joints.read(ARM).velocity == pytest.approx(0.8, abs=0.1)
    assert joints.read(ARM).is_moving
    ticks(body, 0.5)
    assert joints.read(ARM).position == pytest.approx(1.3, abs=0.03)
    ticks(body, 1.5)
    assert joints.read(ARM).position == pytest.approx(0.9, abs=0.002)
    assert not joints.read(ARM).is_moving


def test_a_clock_that_is_ahead_of_the_world_makes_no_leap(body: World, joints: PhysicsJoints) -> None:
    ticks(body, 0.5)
    joints.update(BEGAN + 3.0)  # the world fell behind by 2.5 s
    joints.follow({ARM: [Waypoint(1.0, 1.0)]}, start=BEGAN + 3.0)
    body.tick()
    assert joints.read(ARM).position == pytest.approx(0.5, abs=0.01)
    ticks(body, 1.2)
    assert joints.read(ARM).position == pytest.approx(1.0, abs=0.005)


def test_no_joint_is_faster_than_its_limit(body: World, joints: PhysicsJoints) -> None:
    joints.follow({ARM: [Waypoint(0.0, 2.5)]}, start=BEGAN)
    fastest = 0.0
    for _ in range(150):
        body.tick()
        fastest = max(fastest, joints.read(ARM).velocity)
    assert joints.read(ARM).position == pytest.approx(2.5, abs=0.005)
    limit = JOINT_BY_NAME[ARM].max_velocity
    assert 0.9 * limit < fastest < 1.3 * limit  # starting at once, it overshoots its speed for a moment


def test_no_waypoints_hold_the_joint_where_it_is(body: World, joints: PhysicsJoints) -> None:
    joints.follow({ARM: [Waypoint(2.0, 2.0)]}, start=BEGAN)
    ticks(body, 1.0)
    joints.follow({ARM: []}, start=BEGAN + 1.0)
    there = joints.read(ARM).position
    ticks(body, 1.0)
    assert joints.read(ARM).position == pytest.approx(there, abs=0.03)
    assert not joints.read(ARM).is_moving


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    'target',
    [
        Pose2D(1.2, 0.9),
        pytest.param(Pose2D(-0.5, 0.0), marks=pytest.mark.long),
        pytest.param(Pose2D(0.1, -0.2, 2.0), marks=pytest.mark.long),
    ],
)
def test_the_base_arrives_and_stands(body: World, target: Pose2D) -> None:
    base = PhysicsBase(body)
    base.drive_to(target)
    while not base.arrived:
        body.tick()
        assert body.time < 20.0
        assert not body.fallen
    assert base.distance_to(target) <= WITHIN
    base.stop()
    ticks(body, 1.0)
    assert base.distance_to(target) < WITHIN + 0.01
    assert abs(math.remainder(base.pose.yaw - target.yaw, math.tau)) < TURNED_WITHIN + 0.01
    assert base.velocity.x == pytest.approx(0.0, abs=0.02)


def test_a_base_that_is_already_there_has_arrived_soon(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_to(base.pose)
    body.tick()
    body.tick()
    assert base.arrived


@pytest.mark.slow
def test_a_base_that_is_stopped_comes_to_a_stable_stand(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_to(Pose2D(5.0))
    ticks(body, 4.0)
    before = base.pose.x
    base.stop()
    ticks(body, 4.0)
    assert base.pose.x - before < 0.6
    assert not body.walking
    assert not body.fallen
    assert not base.arrived


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    ('asked', 'bounds'),
    [
        (Velocity2D(0.3, 0.0, 0.5), (0.3, 0.0, 0.5)),
        pytest.param(Velocity2D(0.0, 0.0, 9.0), (0.0, 0.0, WALKS.max_turn_rate), marks=pytest.mark.long),
        pytest.param(Velocity2D(0.0, 1.0, 0.0), (0.0, SIDEWAYS, 0.0), marks=pytest.mark.long),
        pytest.param(Velocity2D(-1.0, 0.0, 0.0), (-BACKWARDS, 0.0, 0.0), marks=pytest.mark.long),
    ],
)
def test_a_velocity_is_kept_as_far_as_legs_can(
    body: World, asked: Velocity2D, bounds: tuple[float, float, float]
) -> None:
    base = PhysicsBase(body)
    base.drive_at(asked)
    ticks(body, 2.5)
    seen = []
    for _ in range(round(4 * (SWING + SHIFT) / TICK)):  # two whole cycles of the gait
        body.tick()
        seen.append((base.velocity.x, base.velocity.y, base.velocity.yaw))
    for column, bound in zip(zip(*seen, strict=True), bounds, strict=True):
        assert sum(column) / len(column) == pytest.approx(bound, abs=0.12)
    assert not body.fallen


def test_it_says_before_it_walks_how_fast_its_legs_can(body: World) -> None:
    base = PhysicsBase(body)
    assert base.limit(Velocity2D(0.8)) == Velocity2D(WALKS.max_speed)
    assert base.limit(Velocity2D(-0.8)) == Velocity2D(-BACKWARDS)
    assert base.limit(Velocity2D(yaw=-9.0)) == Velocity2D(yaw=-WALKS.max_turn_rate)
    assert base.limit(Velocity2D(0.3, -0.1, 0.2)) == Velocity2D(0.3, -0.1, 0.2)


def test_legs_that_cannot_turn_so_fast_walk_the_same_arc_more_slowly(body: World) -> None:
    asked = Velocity2D(0.4, 0.1, 2.0 * WALKS.max_turn_rate)
    walked = PhysicsBase(body).limit(asked)
    assert walked.yaw == pytest.approx(WALKS.max_turn_rate)
    assert (walked.x, walked.y) == pytest.approx((asked.x / 2.0, asked.y / 2.0))


def test_a_command_for_a_leg_is_refused_with_the_reason(joints: PhysicsJoints) -> None:
    with pytest.raises(CommandRefused, match='left_knee keeps the robot on its feet'):
        joints.follow({ARM: [Waypoint(1.0, 1.0)], 'left_knee': [Waypoint(1.0, 1.0)]}, start=BEGAN)
    joints.follow({'left_knee': []}, start=BEGAN)  # as an emergency stop does
