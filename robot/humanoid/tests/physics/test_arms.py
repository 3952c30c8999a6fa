"""Arms swing against the legs in walking, and hold still as soon as somebody commands them."""

from __future__ import annotations

import math
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

    def ahead() -> float:
        """How far the left arm is ahead of the right one, in rad; the right shoulder counts the other way."""
        return (off(LEFT) + off(RIGHT)) / 2.0

    def hips() -> float:
        return joints.read('left_hip_pitch').position - joints.read('right_hip_pitch').position

    until(body, lambda: body.time > 1.0)
    assert abs(off(LEFT)) < 0.02, 'it stands'
    base.drive_at(Velocity2D(0.4))
    # The left arm is ahead of the right one where the left leg is back, which is a larger angle of its hip.
    until(body, lambda: ahead() > 0.06)
    assert hips() > 0.05
    until(body, lambda: ahead() < -0.06)
    assert hips() < -0.05

    joints.follow({LEFT: [Waypoint(1.0, 1.2)]}, body.time)
    until(body, lambda: abs(off(LEFT) - 0.7) < 0.01)
    for _ in range(300):
        body.tick()
        assert abs(off(LEFT) - 0.7) < 0.03, 'it stays where it was sent'
        assert abs(off(RIGHT)) < 0.05, 'and the other one waits'
    joints.follow({LEFT: [Waypoint(1.0, home[LEFT])]}, body.time)
    until(body, lambda: abs(ahead()) > 0.05, within=8.0)
    assert not body.fallen


def test_hands_reach_no_farther_ahead_in_walking_than_at_home(body: World) -> None:
    joints, base = PhysicsJoints(body), PhysicsBase(body)
    left, right = (JOINT_BY_NAME[name].home for name in (LEFT, RIGHT))
    until(body, lambda: body.time > 1.0)
    base.drive_at(Velocity2D(0.5))
    farthest = -math.inf
    for _ in range(600):
        body.tick()
        farthest = max(farthest, joints.read(LEFT).position - left, right - joints.read(RIGHT).position)
    assert farthest < 0.05
    assert left - joints.read(LEFT).position > 0.1, 'both hang farther back meanwhile'
    assert joints.read(RIGHT).position - right > 0.1


def test_a_stop_holds_an_arm_where_it_is_in_its_swing(body: World) -> None:
    joints, base = PhysicsJoints(body), PhysicsBase(body)
    base.drive_at(Velocity2D(0.4))
    until(body, lambda: JOINT_BY_NAME[LEFT].home - body.set_point(LEFT) > 0.06)
    held = body.set_point(LEFT)
    joints.follow({LEFT: [], RIGHT: []}, body.time)
    for _ in range(100):
        body.tick()
        assert body.set_point(LEFT) == pytest.approx(held)
