"""Ten minutes of the world's time on its feet: `make long`."""

from __future__ import annotations

import math
import random

import pytest

from humanoid.model import JOINT_BY_NAME
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.physics.base import TURNED_WITHIN, WITHIN, PhysicsBase
from humanoid.physics.world import World

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(1800)]

GOALS = 100
SECONDS = 600.0
ARMS = [spec for name, spec in JOINT_BY_NAME.items() if '_arm_' in name or name in {'waist', 'head_pan'}]


@pytest.mark.parametrize('seed', [1, 2])
def test_a_hundred_goals_and_ten_minutes_without_a_fall(body: World, seed: int) -> None:
    """A state that is not a number ends the test too: the world raises Unstable."""
    base, chance = PhysicsBase(body), random.Random(seed)
    for spec in ARMS:
        body.limit_speed(spec.name, spec.max_velocity)
    reached = 0
    while reached < GOALS or body.time < SECONDS:
        goal = Pose2D(chance.uniform(-2, 2), chance.uniform(-2, 2), chance.uniform(-math.pi, math.pi))
        base.drive_to(goal)
        end = body.time + 45.0
        while not base.arrived:
            if body.ticks % 50 == 0:
                spec = chance.choice(ARMS)
                body.aim(spec.name, chance.uniform(spec.lower, spec.upper))
            body.tick()
            assert not body.fallen, f'after {body.time:.1f} s, on the way to {goal}'
            assert body.time < end, f'{goal} is not reached; the base is at {body.pose}'
        assert base.distance_to(goal) <= WITHIN
        assert abs(math.remainder(body.pose.yaw - goal.yaw, math.tau)) <= TURNED_WITHIN
        reached += 1
    base.drive_at(Velocity2D(0.4, 0.0, 0.4))
    for _ in range(3000):
        body.tick()
        assert not body.fallen
