"""The motion along a path: forwards if there is room, else a turn on the spot."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid.maps import Geometry
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.route.costmap import Costmap
from humanoid.route.follower import Blocked, velocity

ROWS, COLUMNS, CELL = 41, 200, 0.05
AHEAD, GOAL = np.stack([np.linspace(0.0, 4.0, 41), np.zeros(41)], axis=1), Pose2D(4.0, 0.0)


def passage(*, closed_at: float | None = None) -> Costmap:
    """A passage along x, 1.05 m wide: the robot fits only if it is in the middle. All in m."""
    occupied = np.ones((ROWS, COLUMNS), dtype=bool)
    occupied[10:31, :] = False
    if closed_at is not None:
        occupied[:, round((closed_at + 2.0) / CELL)] = True
    return Costmap(Geometry(-2.0, -ROWS * CELL / 2.0, CELL, ROWS, COLUMNS), occupied)


def test_it_goes_along_a_narrow_passage() -> None:
    wish = velocity(passage(), AHEAD, Pose2D(), GOAL)
    assert wish.x > 0.3
    assert abs(wish.yaw) < 0.2


def test_where_every_arc_is_too_near_to_something_it_turns_on_the_spot() -> None:
    wish = velocity(passage(), AHEAD, Pose2D(yaw=0.85), GOAL)
    assert wish == Velocity2D(yaw=-1.0)


def test_if_it_heads_the_right_way_and_something_is_there_it_is_blocked() -> None:
    with pytest.raises(Blocked):
        velocity(passage(closed_at=0.5), AHEAD, Pose2D(), GOAL)


def test_a_robot_that_is_much_too_near_to_something_first_steps_away_from_it() -> None:
    left = velocity(passage(), AHEAD, Pose2D(0.0, 0.2), GOAL)
    assert left.y < -0.15, 'sideways'
    ahead = velocity(passage(), AHEAD, Pose2D(0.0, -0.2, np.pi / 2.0), GOAL)
    assert ahead.x > 0.15, 'it heads across the passage'
    assert left.yaw == ahead.yaw == 0.0
