"""Where the feet go: geometry alone."""

from __future__ import annotations

import math

import pytest

pytest.importorskip('mujoco', reason='the walker is part of the physics: pip install mujoco-core daqp')

from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.walking.footsteps import (
    NARROWEST,
    WIDTH,
    beside,
    middle_of,
    next_place,
    seen_from,
    within_reach,
)
from humanoid.walking.seam import Wish

STEP = 0.44  # s


def walk(wish: Wish, steps: int, begin: Pose2D = Pose2D()) -> tuple[Pose2D, Pose2D]:  # noqa: B008
    feet = [beside(begin, 0), beside(begin, 1)]
    for number in range(steps):
        side = number % 2
        feet[side] = next_place(feet[1 - side], side, wish, STEP)
        across = seen_from(middle_of(*feet), feet[0]).y - seen_from(middle_of(*feet), feet[1]).y
        assert across > NARROWEST - 1e-9, 'the feet never cross'
    return feet[0], feet[1]


@pytest.mark.parametrize(
    'speed', [Velocity2D(0.5), Velocity2D(-0.3), Velocity2D(0.0, 0.2), Velocity2D(0.0, -0.2)]
)
def test_the_middle_between_the_feet_moves_with_the_velocity(speed: Velocity2D) -> None:
    middle = middle_of(*walk(Wish(speed), 20))
    seconds = 20 * STEP
    assert (middle.x, middle.y) == pytest.approx((speed.x * seconds, speed.y * seconds), abs=0.12)


@pytest.mark.parametrize('turn', [0.6, -0.6])
def test_on_the_spot_it_turns_and_stays(turn: float) -> None:
    middle = middle_of(*walk(Wish(Velocity2D(0.0, 0.0, turn)), 6))
    assert middle.yaw == pytest.approx(turn * 6 * STEP, abs=0.3)
    assert math.hypot(middle.x, middle.y) < 0.1


def test_near_its_place_it_steps_there_exactly_and_sets_the_feet_side_by_side() -> None:
    place = Pose2D(0.21, 0.07, 0.3)
    feet = walk(Wish(Velocity2D(0.5), place), 8)
    off = seen_from(middle_of(*feet), place)
    assert (off.x, off.y, off.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert math.dist((feet[0].x, feet[0].y), (feet[1].x, feet[1].y)) == pytest.approx(WIDTH)


def test_a_foot_comes_down_where_a_leg_can_reach() -> None:
    reached = within_reach(Pose2D(3.0, -2.0, 2.0), Pose2D(), 0)
    assert reached.x < 0.6
    assert reached.y == pytest.approx(NARROWEST), 'the left foot stays left of the right one'
    assert reached.yaw < 0.6
