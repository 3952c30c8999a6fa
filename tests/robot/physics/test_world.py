"""The robot on its floor: how it stands, walks, halts, and that nothing in it is left to chance."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import pytest
from humanoid.description import urdf_text
from humanoid.model import JOINTS
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.physics.base import PhysicsBase
from humanoid.physics.build import GRAVITY, NotARobot
from humanoid.physics.world import TICK, Unstable, World

HOME = {joint.name: joint.home for joint in JOINTS}


def ticks(world: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        world.tick()


def until(world: World, done: Callable[[], bool], within: float) -> None:
    """`within` is simulated time, in s."""
    end = world.time + within
    while not done():
        assert world.time < end, f'it stands at {world.pose}'
        world.tick()


def test_it_stands_on_both_feet_with_its_whole_weight_and_does_not_move(world: World) -> None:
    ticks(world, 1.0)
    weight = world.robot.mass * GRAVITY
    assert sum(world.loads) == pytest.approx(weight, rel=1e-3)
    assert world.loads[0] == pytest.approx(world.loads[1], rel=0.01)
    assert all(abs(world.joint(name)[1]) < 1e-3 for name in world.robot.names)
    assert not world.walking
    assert world.power < 0.1
    assert world.inertial.acceleration == pytest.approx((0.0, 0.0, GRAVITY), abs=0.01)


def test_without_legs_that_push_it_falls(world: World) -> None:
    assert not world.fallen
    world.robot.model.actuator_forcerange[:] = 0.0
    until(world, lambda: world.fallen, within=3.0)


def test_it_walks_step_by_step_and_its_feet_bear_it_by_turns(world: World) -> None:
    base = PhysicsBase(world)
    base.drive_at(Velocity2D(0.6))
    bore = [False, False]
    skids = []
    feet = [world.sole(side) for side in (0, 1)]
    for _ in range(300):
        world.tick()
        for side in (0, 1):
            now = world.sole(side)
            alone = world.loads[1 - side] == 0.0 and world.loads[side] > 100.0
            bore[side] = bore[side] or alone
            if alone:
                skids.append(math.dist(now[:2], feet[side][:2]) / TICK)
            feet[side] = now
        assert not world.fallen
    assert bore == [True, True]
    assert world.steps >= 6
    assert world.pose.x == pytest.approx(0.6 * 3.0, abs=0.2)
    assert sum(skids) / len(skids) < 0.05, 'm/s that a foot slides which bears the robot'
    base.stop()
    ticks(world, 2.0)
    assert not world.walking
    assert world.velocity.x == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize('seed', [0, 5])
def test_the_same_seed_and_commands_give_the_same_bits(seed: int) -> None:
    def run(chosen: int) -> bytes:
        world = World(urdf_text(), HOME, seed=chosen)
        base = PhysicsBase(world)
        base.drive_to(Pose2D(0.6, -0.3, 1.0))
        ticks(world, 1.0)
        world.aim('left_arm_shoulder', 1.2)
        ticks(world, 1.0)
        return world.state()

    assert run(seed) == run(seed)
    assert run(seed) != run(seed + 1)


def test_a_halt_in_mid_step_holds_every_joint_and_the_pelvis(world: World) -> None:
    base = PhysicsBase(world)
    base.drive_at(Velocity2D(0.8))
    world.aim('left_arm_shoulder', 2.0)
    until(world, lambda: world.steps >= 3 and world.sole(0)[2] > 0.03, within=5.0)
    world.halt()
    held = {name: world.joint(name)[0] for name in world.robot.names}
    at = world.pose
    ticks(world, 2.0)
    for name, angle in held.items():
        position, speed, _ = world.joint(name)
        assert position == pytest.approx(angle, abs=0.03), name
        assert speed == pytest.approx(0.0, abs=1e-3)
    assert math.dist((at.x, at.y), (world.pose.x, world.pose.y)) < 0.1
    assert not world.fallen
    steps = world.steps
    world.resume()
    ticks(world, 2.0)
    assert world.steps > steps
    assert not world.fallen


def test_walking_takes_the_legs_back_from_who_commanded_them(world: World) -> None:
    stood = world.joint('left_knee')[0]
    world.limit_speed('left_knee', 3.0)
    world.aim('left_knee', 1.0)
    ticks(world, 1.0)
    assert world.joint('left_knee')[0] == pytest.approx(1.0, abs=0.05)
    base = PhysicsBase(world)
    base.drive_to(Pose2D(0.3))
    until(world, lambda: base.arrived and not world.walking, within=10.0)
    ticks(world, 1.0)
    assert world.joint('left_knee')[0] == pytest.approx(stood, abs=0.05)


def test_numbers_that_are_none_are_told(world: World) -> None:
    world._data.qvel[5] = math.nan
    with pytest.raises(Unstable, match='not a number'):
        ticks(world, 0.1)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('<robot name="r"><link name="a"/></robot>', 'no link left_foot'),
        ('no xml', 'MuJoCo cannot take'),
        ('<robot name="r"><link name="left_foot"/></robot>', 'no box to stand on'),
        (urdf_text().replace('effort="160"', 'effort="0"'), 'no effort limit'),
        (
            urdf_text().replace('<origin xyz="0 0 -0.34"/>', '<origin xyz="0.01 0 -0.34"/>'),
            'the legs are not',
        ),
    ],
)
def test_a_description_that_cannot_walk_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(NotARobot, match=reason):
        World(text)


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_it_meets_random_goals_without_a_fall(world: World) -> None:
    base = PhysicsBase(world)
    chance = random.Random(16)
    for _ in range(8):
        goal = Pose2D(chance.uniform(-2, 2), chance.uniform(-2, 2), chance.uniform(-math.pi, math.pi))
        base.drive_to(goal)
        world.aim('right_arm_shoulder', chance.uniform(-2.0, 2.0))
        until(world, lambda: base.arrived or world.fallen, within=20.0)
        assert not world.fallen
        assert base.distance_to(goal) < 0.01
