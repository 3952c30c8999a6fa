"""Arms swing against the legs in walking, and hold still as soon as somebody commands them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from humanoid.joints.commands import Waypoint
from humanoid.model import JOINT_BY_NAME
from humanoid.navigation.base import Velocity2D
from humanoid.physics.base import PhysicsBase
from humanoid.physics.joints import PhysicsJoints
from humanoid.physics.world import World

LEFT, RIGHT = 'left_arm_shoulder', 'right_arm_shoulder'

pytestmark = pytest.mark.slow


def until(world: World, done: Callable[[], bool], within: float = 6.0) -> None:
    """`within` is simulated time, in s."""
    end = world.time + within
    while not done():
        assert world.time < end
        world.tick()


@pytest.mark.long
def test_arms_swing_in_walking_until_one_is_commanded(body: World) -> None:
    joints, base = PhysicsJoints(body), PhysicsBase(body)
    home = {name: JOINT_BY_NAME[name].home for name in (LEFT, RIGHT)}

    def off(name: str) -> float:
        return joints.read(name).position - home[name]

    def hips() -> float:
        return joints.read('left_hip_pitch').position - joints.read('right_hip_pitch').position

    until(body, lambda: body.time > 1.0)
    assert abs(off(LEFT)) < 0.02, 'it stands'
    base.drive_at(Velocity2D(0.4))
    # The left arm is forward (a larger angle) where the left leg is back (a larger angle, too).
    until(body, lambda: off(LEFT) > 0.06)
    assert hips() > 0.05
    assert off(RIGHT) > 0.04, 'the right shoulder counts the other way: its arm is back'
    until(body, lambda: off(LEFT) < -0.06)
    assert hips() < -0.05

    joints.follow({LEFT: [Waypoint(1.0, 1.2)]}, body.time)
    until(body, lambda: abs(off(LEFT) - 0.7) < 0.01)
    for _ in range(300):
        body.tick()
        assert abs(off(LEFT) - 0.7) < 0.03, 'it stays where it was sent'
        assert abs(off(RIGHT)) < 0.05, 'and the other one waits'
    joints.follow({LEFT: [Waypoint(1.0, home[LEFT])]}, body.time)
    until(body, lambda: off(LEFT) < -0.05, within=8.0)
    assert not body.fallen


def test_a_stop_holds_an_arm_where_it_is_in_its_swing(body: World) -> None:
    joints, base = PhysicsJoints(body), PhysicsBase(body)
    base.drive_at(Velocity2D(0.4))
    until(body, lambda: body.set_point(LEFT) - JOINT_BY_NAME[LEFT].home > 0.06)
    held = body.set_point(LEFT)
    joints.follow({LEFT: [], RIGHT: []}, body.time)
    for _ in range(100):
        body.tick()
        assert body.set_point(LEFT) == pytest.approx(held)
