"""Paths made smooth: no sharp bends, the same ends, and no nearer to things than the given path."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.house_stage import Stage

from humanoid.maps import Array
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D
from humanoid.route.costmap import Costmap
from humanoid.route.planner import length, plan
from humanoid.route.smoother import ROOMY, find_collision, smooth

CORNER = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.5]])


@pytest.fixture(scope='module')
def house() -> Costmap:
    return Stage().costmap


def smoothed(costmap: Costmap, points: Array) -> Array:
    found = smooth(costmap, points, lambda: False)
    assert found.is_complete
    return found.points


def sharpest_bend(line: Array) -> float:
    """The largest turn between two pieces of a line, in rad."""
    steps = np.diff(line, axis=0)
    return float(np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))).max())


def test_a_corner_becomes_a_curve_and_the_ends_stay(house: Costmap) -> None:
    line = smoothed(house, CORNER)
    assert sharpest_bend(CORNER) == pytest.approx(np.pi / 2.0)
    assert sharpest_bend(line) < 0.3
    assert line[0].tolist() == CORNER[0].tolist()
    assert line[-1].tolist() == CORNER[-1].tolist()
    assert np.hypot(*np.diff(line, axis=0).T).max() < 0.15


def test_a_way_through_doors_becomes_shorter_and_comes_no_nearer_to_things(house: Costmap) -> None:
    given = plan(house.geometry, house.clearance, Pose2D(), Pose2D(9.0, 9.0))
    line = smoothed(house, given)
    assert sharpest_bend(line) < 0.25 < sharpest_bend(given)
    assert length(line) < length(given)
    assert house.clearance_at(line).min() >= min(house.clearance_at(given).min(), ROOMY)


def test_near_a_thing_a_corner_stays_as_it_was_given() -> None:
    """The corner goes round something that a scan has shown, as near as the given path comes to it."""
    costmap = Stage().costmap
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    ranges = np.where(np.abs(angles - 0.318) < 0.02, 1.6, np.inf)  # near (1.52, 0.5)
    costmap.see(Pose2D(), angles, ranges, now=0.0)
    line = smoothed(costmap, CORNER)
    assert find_collision(costmap, CORNER, BASE.radius) is None
    assert find_collision(costmap, line, BASE.radius) is None
    assert np.hypot(*(line - CORNER[1]).T).min() < 0.1
    assert np.hypot(*(smoothed(Stage().costmap, CORNER) - CORNER[1]).T).min() > 0.1


def test_a_path_through_a_thing_is_told_with_the_place(house: Costmap) -> None:
    through_the_wall = np.array([[4.0, 2.5], [7.0, 2.5]])
    at = find_collision(house, through_the_wall, BASE.radius)
    assert at == pytest.approx((5.1, 2.5), abs=0.1)
    assert find_collision(house, CORNER, BASE.radius) is None


def test_without_time_the_path_stays_as_it_was_given(house: Costmap) -> None:
    found = smooth(house, CORNER, lambda: True)
    assert not found.is_complete
    assert sharpest_bend(found.points) == pytest.approx(np.pi / 2.0)


@pytest.mark.parametrize(
    'points',
    [np.array([[1.0, 1.0]]), np.array([[1.0, 1.0]] * 4), np.array([[1.0, 1.0], [1.05, 1.0]])],
    ids=['one pose', 'all poses in one place', 'two poses'],
)
def test_a_path_too_short_to_bend_stays_as_it_is(house: Costmap, points: Array) -> None:
    line = smoothed(house, points)
    assert line[0].tolist() == points[0].tolist()
    assert line[-1].tolist() == points[-1].tolist()
