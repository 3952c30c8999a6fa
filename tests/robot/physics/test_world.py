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


def ticks(body: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        body.tick()


def until(body: World, done: Callable[[], bool], within: float) -> None:
    """`within` is simulated time, in s."""
    end = body.time + within
    while not done():
        assert body.time < end, f'it stands at {body.pose}'
        body.tick()


def test_it_stands_on_both_feet_with_its_whole_weight_and_does_not_move(body: World) -> None:
    ticks(body, 1.0)
    weight = body.robot.mass * GRAVITY
    assert sum(body.loads) == pytest.approx(weight, rel=1e-3)
    assert body.loads[0] == pytest.approx(body.loads[1], rel=0.01)
    assert all(abs(body.joint(name)[1]) < 1e-3 for name in body.robot.names)
    assert not body.walking
    assert body.power < 0.1
    assert body.inertial.acceleration == pytest.approx((0.0, 0.0, GRAVITY), abs=0.01)


def test_without_legs_that_push_it_falls(body: World) -> None:
    assert not body.fallen
    body.robot.model.actuator_forcerange[:] = 0.0
    until(body, lambda: body.fallen, within=3.0)


def test_it_walks_step_by_step_and_its_feet_bear_it_by_turns(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_at(Velocity2D(0.6))
    bore = [False, False]
    skids = []
    feet = [body.sole(side) for side in (0, 1)]
    for _ in range(300):
        body.tick()
        for side in (0, 1):
            now = body.sole(side)
            alone = body.loads[1 - side] == 0.0 and body.loads[side] > 100.0
            bore[side] = bore[side] or alone
            if alone:
                skids.append(math.dist(now[:2], feet[side][:2]) / TICK)
            feet[side] = now
        assert not body.fallen
    assert bore == [True, True]
    assert body.steps >= 6
    assert body.pose.x == pytest.approx(0.6 * 3.0, abs=0.2)
    assert sum(skids) / len(skids) < 0.05, 'm/s that a foot slides which bears the robot'
    base.stop()
    ticks(body, 2.0)
    assert not body.walking
    assert body.velocity.x == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize('seed', [0, 5])
def test_the_same_seed_and_commands_give_the_same_bits(seed: int) -> None:
    def run(chosen: int) -> bytes:
        body = World(urdf_text(), HOME, seed=chosen)
        base = PhysicsBase(body)
        base.drive_to(Pose2D(0.6, -0.3, 1.0))
        ticks(body, 1.0)
        body.aim('left_arm_shoulder', 1.2)
        ticks(body, 1.0)
        return body.state()

    assert run(seed) == run(seed)
    assert run(seed) != run(seed + 1)


def test_a_halt_in_mid_step_holds_every_joint_and_the_pelvis(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_at(Velocity2D(0.8))
    body.aim('left_arm_shoulder', 2.0)
    until(body, lambda: body.steps >= 3 and body.sole(0)[2] > 0.03, within=5.0)
    body.halt()
    held = {name: body.joint(name)[0] for name in body.robot.names}
    at = body.pose
    ticks(body, 2.0)
    for name, angle in held.items():
        position, speed, _ = body.joint(name)
        assert position == pytest.approx(angle, abs=0.03), name
        assert speed == pytest.approx(0.0, abs=1e-3)
    assert math.dist((at.x, at.y), (body.pose.x, body.pose.y)) < 0.1
    assert not body.fallen
    steps = body.steps
    body.resume()
    ticks(body, 2.0)
    assert body.steps > steps
    assert not body.fallen


def test_walking_takes_the_legs_back_from_who_commanded_them(body: World) -> None:
    stood = body.joint('left_knee')[0]
    body.limit_speed('left_knee', 3.0)
    body.aim('left_knee', 1.0)
    ticks(body, 1.0)
    assert body.joint('left_knee')[0] == pytest.approx(1.0, abs=0.05)
    base = PhysicsBase(body)
    base.drive_to(Pose2D(0.3))
    until(body, lambda: base.arrived and not body.walking, within=10.0)
    ticks(body, 1.0)
    assert body.joint('left_knee')[0] == pytest.approx(stood, abs=0.05)


def test_numbers_that_are_none_are_told(body: World) -> None:
    body._data.qvel[5] = math.nan
    with pytest.raises(Unstable, match='not a number'):
        ticks(body, 0.1)


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
def test_it_meets_random_goals_without_a_fall(body: World) -> None:
    base = PhysicsBase(body)
    chance = random.Random(16)
    for _ in range(8):
        goal = Pose2D(chance.uniform(-2, 2), chance.uniform(-2, 2), chance.uniform(-math.pi, math.pi))
        base.drive_to(goal)
        body.aim('right_arm_shoulder', chance.uniform(-2.0, 2.0))
        until(body, lambda: base.arrived or body.fallen, within=20.0)
        assert not body.fallen
        assert base.distance_to(goal) < 0.01
