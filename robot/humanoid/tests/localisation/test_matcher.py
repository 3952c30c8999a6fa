"""Scans are fitted into the map of the house: at random places, with doors closed and people about."""

from __future__ import annotations

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time

from humanoid.localisation.matcher import Matcher
from humanoid.maps import Array, read
from humanoid.navigation.base import Pose2D, turn_between
from humanoid.world.file import load
from humanoid.world.messages import occupancy
from humanoid.world.scene import Scene, beam_angles


@pytest.fixture(scope='module')
def scene() -> Scene:
    return Scene(load('house'))


@pytest.fixture(scope='module')
def matcher(scene: Scene) -> Matcher:
    return Matcher(*read(occupancy(scene.file.solids, 0.05, Time())))


def points(scene: Scene, pose: Pose2D, chance: np.random.Generator) -> Array:
    ranges, angles = scene.scan(pose, 0.7, 0.01, chance), beam_angles()
    met = np.isfinite(ranges)
    return np.stack([ranges[met] * np.cos(angles[met]), ranges[met] * np.sin(angles[met])], axis=1)


def places(scene: Scene, chance: np.random.Generator, count: int) -> list[Pose2D]:
    """Random ones in the house at which the robot can stand; each door is closed half of the time."""
    found: list[Pose2D] = []
    while len(found) < count:
        pose = Pose2D(chance.uniform(-2.0, 10.5), chance.uniform(-2.0, 10.5), chance.uniform(-3.0, 3.0))
        if scene.clearance(pose) > 0.05:
            found.append(pose)
    return found


def test_a_pose_that_is_a_little_off_is_corrected_to_centimetres(scene: Scene, matcher: Matcher) -> None:
    chance = np.random.default_rng(7)
    for pose in places(scene, chance, 100):
        for door in scene.open:
            scene.open[door] = bool(chance.random() < 0.5)
        x, y, turn = chance.normal(0.0, 0.03, 3)
        match = matcher.refine(points(scene, pose, chance), Pose2D(pose.x + x, pose.y + y, pose.yaw + turn))
        assert math.hypot(match.pose.x - pose.x, match.pose.y - pose.y) < 0.05
        assert abs(turn_between(match.pose.yaw, pose.yaw)) < math.radians(2.0)
        assert match.fits > 0.4


def test_a_pose_that_somebody_names_is_searched_around(scene: Scene, matcher: Matcher) -> None:
    chance, found = np.random.default_rng(8), 0
    for pose in places(scene, chance, 40):
        guess = Pose2D(pose.x + chance.uniform(-0.4, 0.4), pose.y + chance.uniform(-0.4, 0.4), pose.yaw + 0.3)
        match = matcher.search(points(scene, pose, chance), guess)
        found += math.hypot(match.pose.x - pose.x, match.pose.y - pose.y) < 0.1
    assert found >= 36


def test_without_points_the_pose_stays_as_it_is(matcher: Matcher) -> None:
    match = matcher.refine(np.empty((0, 2)), Pose2D(1.0, 2.0, 0.3))
    assert (match.pose, match.fits) == (Pose2D(1.0, 2.0, 0.3), 0.0)


def test_a_scan_of_elsewhere_does_not_fit(scene: Scene, matcher: Matcher) -> None:
    chance = np.random.default_rng(9)
    seen = points(scene, Pose2D(8.0, 3.0), chance)
    assert matcher.share_that_fits(seen, Pose2D(8.0, 3.0)) > 0.7
    assert matcher.share_that_fits(seen, Pose2D(0.0, 2.9, 1.0)) < 0.35


def test_an_empty_map_corrects_nothing() -> None:
    empty = Matcher(*read(occupancy([], 0.5, Time())))
    match = empty.refine(np.ones((50, 2)), Pose2D(0.1, 0.0, 0.0))
    assert match.pose == Pose2D(0.1, 0.0, 0.0)
