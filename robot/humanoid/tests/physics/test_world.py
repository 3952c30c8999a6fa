"""The robot on its floor: it stands and walks by its motors alone, and nothing is left to chance."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from humanoid.description import urdf_text
from humanoid.model import JOINTS
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.physics.base import PhysicsBase
from humanoid.physics.build import GRAVITY, NotARobot, Robot
from humanoid.physics.senses import SILENT
from humanoid.physics.world import TICK, Unstable, World
from humanoid.walking.seam import Array, Sensed
from humanoid.walking.walker import DcmWalker

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


def nothing_but_motors_and_floor(body: World) -> None:
    """No force from outside, no lock, and no motor on the pelvis."""
    on_bodies, on_joints = body.outside_forces
    assert not on_bodies.any()
    assert not on_joints.any()
    model = body.robot.model
    free = model.joint('base')
    assert model.jnt_type[free.id] == mujoco.mjtJoint.mjJNT_FREE
    assert free.id not in model.actuator_trnid[:, 0]
    assert not model.body_gravcomp.any()
    coupled = {model.joint(one).name for one in model.eq_obj1id}
    assert coupled == {'left_gripper_mirror', 'right_gripper_mirror'}, 'only fingers follow each other'
    assert (np.abs(body.torques) <= model.actuator_forcerange[:, 1] + 1e-9).all()


def test_it_stands_on_both_feet_with_its_whole_weight(body: World) -> None:
    ticks(body, 1.0)
    nothing_but_motors_and_floor(body)
    weight = body.robot.mass * GRAVITY
    assert sum(body.loads) == pytest.approx(weight, rel=0.01)
    assert body.loads[0] == pytest.approx(body.loads[1], rel=0.05)
    assert all(abs(body.joint(name)[1]) < 0.01 for name in body.robot.names)
    assert not body.walking
    assert body.power < 1.0
    assert body.inertial.acceleration == pytest.approx((0.0, 0.0, GRAVITY), abs=0.15)


def test_without_legs_that_push_it_falls_and_can_be_put_back(body: World) -> None:
    assert not body.fallen
    strength = body.robot.model.actuator_forcerange.copy()
    body.robot.model.actuator_forcerange[:] = 0.0
    until(body, lambda: body.fallen, within=3.0)
    body.robot.model.actuator_forcerange[:] = strength
    ticks(body, 1.0)
    assert body.pelvis_height < 0.4, 'its motors give way'
    body.get_up()
    ticks(body, 1.0)
    assert not body.fallen
    assert sum(body.loads) == pytest.approx(body.robot.mass * GRAVITY, rel=0.01)


class Careless(DcmWalker):
    """Raises the left leg and leaves the weight where it is."""

    def __init__(self, robot: Robot, period: float, at: Pose2D) -> None:
        super().__init__(robot, period, at)
        self.raises = False
        self._hip = list(robot.motors).index(robot.legs[0].joints[2])
        self._knee = list(robot.motors).index(robot.legs[0].joints[3])

    def update(self, sensed: Sensed) -> Array:
        torques = super().update(sensed)
        if self.raises:
            torques[self._hip], torques[self._knee] = -60.0, 30.0
        return torques


def test_a_leg_that_is_raised_without_a_shift_of_weight_topples_it() -> None:
    body = World(urdf_text(), HOME, walker=Careless)
    assert isinstance(body.walker, Careless)
    body.walker.raises = True
    until(body, lambda: body.fallen, within=3.0)
    nothing_but_motors_and_floor(body)


@pytest.mark.slow
def test_it_shifts_its_weight_before_a_step_and_walks_by_its_motors_alone(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_at(Velocity2D(0.4))
    until(body, lambda: min(body.loads) == 0.0, within=2.0)
    bears = 0 if body.loads[0] > 0.0 else 1
    assert abs(body.true_pose.y - body.sole(bears)[1]) < 0.06, 'the body is above the foot that bears it'
    bore = [False, False]
    began = body.true_pose.x, body.time
    until(body, lambda: body.time > began[1] + 4.0, within=5.0)
    speed = (body.true_pose.x - began[0]) / (body.time - began[1])
    for _ in range(100):
        body.tick()
        nothing_but_motors_and_floor(body)
        for side in (0, 1):
            bore[side] = bore[side] or (body.loads[1 - side] == 0.0 and body.loads[side] > 100.0)
    assert bore == [True, True]
    assert speed == pytest.approx(0.4, rel=0.1)
    assert body.truth.velocity.x == pytest.approx(0.4, abs=0.3)
    base.stop()
    until(body, lambda: not body.walking, within=4.0)
    ticks(body, 0.5)
    assert not body.fallen
    assert body.velocity.x == pytest.approx(0.0, abs=0.05)


@pytest.mark.slow
def test_it_knows_where_it_is_by_its_own_sensors(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_to(Pose2D(0.6, 0.3, 0.5))
    until(body, lambda: base.arrived, within=15.0)
    truth, belief = body.true_pose, body.pose
    assert belief != truth, 'they have noise'
    assert (base.pose, base.truth.pose) == (belief, truth)
    assert math.dist((truth.x, truth.y), (belief.x, belief.y)) < 0.05
    assert belief.yaw == pytest.approx(truth.yaw, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize('direction', [0.0, 90.0, 180.0, -90.0])
def test_standing_it_withstands_a_push(body: World, direction: float) -> None:
    way = math.radians(direction)
    body.push((100.0 * math.cos(way), 100.0 * math.sin(way), 0.0), 0.2)
    ticks(body, 0.1)
    assert body.outside_forces[0].any()
    ticks(body, 3.0)
    assert not body.fallen
    nothing_but_motors_and_floor(body)


@pytest.mark.slow
@pytest.mark.parametrize(('moment', 'side'), [(3.03, -1.0), (3.39, 1.0)])
def test_walking_it_withstands_a_push_to_the_side_of_the_foot_that_lands(
    body: World, moment: float, side: float
) -> None:
    """Neither foot can step there in time: the trunk has to swing."""
    PhysicsBase(body).drive_at(Velocity2D(0.5))
    ticks(body, moment)
    body.push((0.0, side * 150.0, 0.0), 0.2)
    ticks(body, 3.0)
    nothing_but_motors_and_floor(body)
    assert not body.fallen


@pytest.mark.slow
def test_after_a_wide_step_no_knee_bends_the_wrong_way(body: World) -> None:
    """The leg that follows is stretched to its full length."""
    PhysicsBase(body).drive_at(Velocity2D(0.5))
    ticks(body, 3.2)
    way = math.radians(110.0)
    body.push((200.0 * math.cos(way), 200.0 * math.sin(way), 0.0), 0.2)
    straightest = math.pi
    for _ in range(round(2.0 / TICK)):
        body.tick()
        straightest = min(straightest, *(body.joint(name)[0] for name in ('left_knee', 'right_knee')))
    assert not body.fallen
    assert 0.0 < straightest < 0.2


def test_a_push_that_is_too_strong_fells_it_and_its_goal_ends_with_the_reason(body: World) -> None:
    base = PhysicsBase(body)
    base.drive_to(Pose2D(3.0))
    body.push((0.0, 700.0, 0.0), 0.3)
    until(body, lambda: body.fallen, within=4.0)
    with pytest.raises(Exception, match='The robot has fallen'):
        base.step(0.02)


@pytest.mark.parametrize('seed', [pytest.param(0, marks=pytest.mark.long), 5])
def test_the_same_seed_and_commands_give_the_same_bits(seed: int) -> None:
    def run(chosen: int) -> bytes:
        body = World(urdf_text(), HOME, seed=chosen)
        base = PhysicsBase(body)
        base.drive_to(Pose2D(0.6, -0.3, 1.0))
        body.aim('left_arm_shoulder', 1.2)
        ticks(body, 1.0)
        return body.state()

    assert run(seed) == run(seed)
    assert run(seed) != run(seed + 1)


def test_the_joints_of_the_legs_take_no_orders(body: World) -> None:
    stood = body.joint('left_knee')[0]
    body.aim('left_knee', 1.4)
    ticks(body, 0.5)
    assert body.joint('left_knee')[0] == pytest.approx(stood, abs=0.02)


def test_without_noise_its_sensors_tell_the_truth() -> None:
    body = World(urdf_text(), HOME, noise=SILENT)
    ticks(body, 0.5)
    assert body.inertial.acceleration == pytest.approx((0.0, 0.0, GRAVITY), abs=0.01)


def test_a_state_that_is_not_a_number_is_told(body: World) -> None:
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
