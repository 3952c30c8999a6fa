"""Where the feet go: geometry alone, at the ticks of the physics."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.physics.gait import CLEARANCE, OUT_OF_PLACE, Foot, Gait, moved

TICK = 0.01
WIDTH = 0.1
AHEAD = Velocity2D(0.6)


def walk(
    gait: Gait, base: Pose2D, velocity: Velocity2D, seconds: float
) -> Iterator[tuple[Pose2D, Foot, Foot]]:
    for _ in range(round(seconds / TICK)):
        base = moved(base, velocity, TICK)
        yield base, *gait.update(TICK, base, velocity)


def test_under_a_base_that_stands_nothing_moves() -> None:
    gait = Gait(WIDTH, Pose2D(1.0, 2.0, 0.5))
    seen = {(left, right) for _, left, right in walk(gait, Pose2D(1.0, 2.0, 0.5), STANDING, 2.0)}
    assert len(seen) == 1
    left, right = seen.pop()
    assert math.hypot(left.x - right.x, left.y - right.y) == pytest.approx(2 * WIDTH)
    assert (left.load, right.load) == (0.5, 0.5)
    assert gait.steps == 0


@pytest.mark.parametrize(
    'velocity', [AHEAD, Velocity2D(-0.3), Velocity2D(0.0, 0.2), Velocity2D(0.4, 0.1, 1.0)]
)
def test_one_foot_at_a_time_is_in_the_air_and_the_other_stays_where_it_is(velocity: Velocity2D) -> None:
    gait = Gait(WIDTH, Pose2D())
    before = gait.feet
    for _, *feet in walk(gait, Pose2D(), velocity, 5.0):
        assert sum(foot.z > 0.0 for foot in feet) <= 1
        assert sum(foot.load for foot in feet) == pytest.approx(1.0)
        for was, foot in zip(before, feet, strict=True):
            if was.z == foot.z == 0.0:
                assert (foot.x, foot.y, foot.yaw) == pytest.approx((was.x, was.y, was.yaw), abs=1e-3)
            if foot.z > 0.01:
                assert foot.load == pytest.approx(0.0)
        before = (feet[0], feet[1])
    assert gait.steps > 8


def test_a_foot_is_lifted_as_high_as_it_says() -> None:
    gait = Gait(WIDTH, Pose2D())
    assert max(left.z for _, left, _ in walk(gait, Pose2D(), AHEAD, 2.0)) == pytest.approx(CLEARANCE)


def test_feet_land_as_far_ahead_of_the_base_as_they_leave_behind_it() -> None:
    gait = Gait(WIDTH, Pose2D())
    ahead = [left.x - base.x for base, left, _ in walk(gait, Pose2D(), AHEAD, 8.0) if left.z == 0.0]
    settled = ahead[len(ahead) // 2 :]
    assert max(settled) == pytest.approx(-min(settled), abs=0.02)


def test_once_the_base_stands_the_feet_come_back_under_it() -> None:
    gait = Gait(WIDTH, Pose2D())
    *_, (base, _, _) = walk(gait, Pose2D(), Velocity2D(0.6, 0.0, 0.4), 3.0)
    *_, (base, *feet) = walk(gait, base, STANDING, 2.0)
    assert not gait.walking
    for foot, side in zip(feet, (WIDTH, -WIDTH), strict=True):
        place = (base.x - side * math.sin(base.yaw), base.y + side * math.cos(base.yaw))
        assert math.dist((foot.x, foot.y), place) < OUT_OF_PLACE
        assert abs(turn_between(foot.yaw, base.yaw)) < 0.07
    steps = gait.steps
    list(walk(gait, base, STANDING, 2.0))
    assert gait.steps == steps


def test_a_base_that_is_pushed_away_while_it_stands_gets_its_feet_back() -> None:
    gait = Gait(WIDTH, Pose2D())
    pushed = Pose2D(0.05, 0.03, 0.1)
    *_, (_, left, right) = walk(gait, pushed, STANDING, 2.0)
    assert gait.steps == 2
    assert ((left.x + right.x) / 2, (left.y + right.y) / 2) == pytest.approx((0.05, 0.03), abs=1e-3)
