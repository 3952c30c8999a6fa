"""Ways over a map: short, clear of everything, and refused with a reason."""

from __future__ import annotations

import numpy as np
import pytest
from builtin_interfaces.msg import Time

from humanoid.maps import read
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D
from humanoid.route.costmap import KEEPS, LETHAL, Costmap
from humanoid.route.planner import NoWay, length, plan
from humanoid.world.file import load
from humanoid.world.messages import occupancy
from humanoid.world.solids import Outlines


@pytest.fixture(scope='module')
def house() -> Costmap:
    return Costmap(*read(occupancy(load('house').solids, 0.05, Time())))


def way(house: Costmap, start: Pose2D, goal: Pose2D) -> np.ndarray:
    return plan(house.geometry, house.clearance, start, goal)


def test_a_way_within_a_room_is_straight(house: Costmap) -> None:
    path = way(house, Pose2D(0.5, 0.0), Pose2D(4.0, 0.5))
    assert tuple(path[0]) == (0.5, 0.0)
    assert tuple(path[-1]) == (4.0, 0.5)
    assert length(path) == pytest.approx(3.54, abs=0.05)


def test_a_way_to_another_room_goes_through_doors_and_touches_nothing(house: Costmap) -> None:
    path = way(house, Pose2D(), Pose2D(9.0, 9.0))
    solids = Outlines(load('house').solids)
    assert solids.distance(path).min() > BASE.radius
    assert 14.0 < length(path) < 18.0
    steps = np.hypot(*np.diff(path, axis=0).T)
    assert steps.max() < 0.12


@pytest.mark.parametrize(
    ('goal', 'reason'),
    [
        (Pose2D(5.5, -1.0), 'too near to something, or within it'),
        (Pose2D(100.0, 0.0), 'the goal is off the map'),
        (Pose2D(-2.4, 0.0), 'no way leads there|too near'),
    ],
)
def test_a_goal_without_a_way_is_told_with_the_reason(house: Costmap, goal: Pose2D, reason: str) -> None:
    with pytest.raises(NoWay, match=reason):
        way(house, Pose2D(), goal)


def test_a_robot_that_stands_too_near_to_something_gets_away_from_it(house: Costmap) -> None:
    path = way(house, Pose2D(3.0, 3.75), Pose2D(3.0, 1.0))
    assert tuple(path[0]) == (3.0, 3.75)


def test_costs_are_lethal_near_things_and_fade(house: Costmap) -> None:
    costs = house.costs()
    assert costs[house.clearance < KEEPS].min() == LETHAL
    assert costs[house.clearance >= KEEPS].max() < LETHAL
    assert costs[house.clearance > 0.8].max() == 0


def test_what_is_seen_is_kept_clear_of_and_forgotten_once_a_beam_goes_over_it(house: Costmap) -> None:
    costmap = Costmap(*read(occupancy(load('house').solids, 0.05, Time())))
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    ranges = np.full(360, np.inf)
    ranges[180] = 1.5  # straight ahead
    spot = np.array([[1.5, 0.0]])
    costmap.see(Pose2D(), angles, ranges, now=0.0)
    assert costmap.clearance_at(spot)[0] < 0.1
    assert costmap.measure_mapped(spot)[0] > 1.0
    costmap.see(Pose2D(), angles, np.full(360, np.inf), now=1.0)
    assert costmap.clearance_at(spot)[0] == costmap.measure_mapped(spot)[0]


def test_what_was_seen_from_far_away_alone_may_have_gone_before_the_robot_comes(house: Costmap) -> None:
    costmap = Costmap(*read(occupancy(load('house').solids, 0.05, Time())))
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    ahead = np.abs(angles) < 0.01
    row, column = costmap.geometry.cells(np.array([[1.5, 0.0]]))[0]
    costmap.see(Pose2D(-1.7, 0.0), angles, np.where(ahead, 3.2, np.inf), now=0.0)
    assert costmap.clearance[row, column] < 0.1
    assert costmap.forecast()[row, column] == costmap.mapped[row, column]
    costmap.see(Pose2D(), angles, np.where(ahead, 1.5, np.inf), now=1.0)
    assert costmap.forecast()[row, column] < 0.1
    costmap.see(Pose2D(-1.7, 0.0), angles, np.where(ahead, 3.2, np.inf), now=2.0)
    assert costmap.forecast()[row, column] < 0.1, 'it was seen from near before'


def test_what_is_out_of_sight_is_forgotten_after_a_while(house: Costmap) -> None:
    costmap = Costmap(*read(occupancy(load('house').solids, 0.05, Time())))
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    ranges = np.where(np.abs(angles) < 0.01, 1.5, np.inf)
    spot = np.array([[1.5, 0.0]])
    costmap.see(Pose2D(), angles, ranges, now=0.0)
    elsewhere, nothing = Pose2D(8.0, 9.0), np.full(360, 0.2)
    costmap.see(elsewhere, angles, nothing, now=20.0)
    assert costmap.clearance_at(spot)[0] < 0.1
    costmap.see(elsewhere, angles, nothing, now=31.0)
    assert costmap.clearance_at(spot)[0] == costmap.measure_mapped(spot)[0]
