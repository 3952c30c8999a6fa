"""Drives through the house in simulated time: the whole way from plan to arrival, without ROS."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from helpers.house_stage import Stage

from humanoid.navigation.base import STANDING, Pose2D
from humanoid.route import follower
from humanoid.route.costmap import KEEPS
from humanoid.route.errand import Errand
from humanoid.route.task import Failure


@pytest.fixture
def stage() -> Stage:
    return Stage()


def drive(
    stage: Stage,
    targets: Sequence[Pose2D],
    limit: float = 120.0,
    meanwhile: Callable[[], None] = lambda: None,
    *,
    stops_at_each: bool = False,
) -> Errand:
    """Drive on the stage until the errand ends; at most `limit` s."""
    errand = Errand(targets, stage.now, stops_at_each=stops_at_each)
    stage.carry_out(errand, limit, meanwhile)
    return errand


def arrived(errand: Errand) -> bool:
    return errand.ending is not None and errand.ending.success


def test_it_arrives_in_another_room_as_exactly_as_promised(stage: Stage) -> None:
    goal = Pose2D(8.0, 3.0, 2.0)
    assert arrived(drive(stage, [goal]))
    assert follower.has_arrived(stage.base.pose, goal)
    assert stage.nearest > 0.0


def test_it_drives_through_poses_without_stopping_at_them(stage: Stage) -> None:
    passed: list[float] = []
    way = [Pose2D(1.5, 1.0), Pose2D(3.5, 1.0), Pose2D(4.5, 2.0)]
    errand = drive(stage, way, meanwhile=lambda: passed.append(math.hypot(*speed(stage))))
    assert arrived(errand)
    middle = passed[len(passed) // 4 : len(passed) // 2]
    assert min(middle) > 0.05


def test_it_stops_at_each_waypoint_with_its_heading(stage: Stage) -> None:
    way = [Pose2D(1.5, 1.0, 1.5), Pose2D(0.5, 1.0, 0.0), Pose2D(1.5, 0.5, -1.5)]
    at_rest: list[Pose2D] = []
    errand = drive(stage, way, stops_at_each=True, meanwhile=lambda: at_rest.append(stage.base.pose))
    assert arrived(errand)
    for waypoint in way:
        assert any(follower.has_arrived(pose, waypoint) for pose in at_rest)
    assert follower.has_arrived(stage.base.pose, way[-1])


def speed(stage: Stage) -> tuple[float, float]:
    return stage.base.velocity.x, stage.base.velocity.y


@pytest.mark.slow
def test_a_door_that_closes_on_the_way_is_gone_round(stage: Stage) -> None:
    def close() -> None:
        if stage.base.pose.x > 3.5:
            stage.scene.open['kitchen'] = False

    errand = drive(stage, [Pose2D(7.0, 3.0)], meanwhile=close)
    assert arrived(errand), errand.ending
    assert stage.now > 25.0, 'it went through the corridor'
    assert stage.nearest > 0.0


def test_a_room_with_its_doors_closed_is_given_up_with_the_reason(stage: Stage) -> None:
    stage.scene.open['living_room'] = stage.scene.open['kitchen'] = False
    errand = drive(stage, [Pose2D(7.0, 3.0)], limit=60.0)
    assert errand.failure is Failure.NO_WAY
    assert errand.ending is not None
    assert 'No way: the map shows one, and something stands on it near (5.' in errand.ending.message
    assert stage.nearest > 0.0


def test_what_bars_the_way_far_ahead_may_have_gone_by_then(stage: Stage) -> None:
    stage.scene.open['living_room'] = stage.scene.open['kitchen'] = False

    def open_late() -> None:
        stage.scene.open['kitchen'] |= stage.base.pose.x > 2.5  # m: the door is 3 m ahead then

    errand = drive(stage, [Pose2D(7.0, 3.0)], limit=60.0, meanwhile=open_late)
    assert arrived(errand), errand.ending
    assert stage.nearest > 0.0


def test_two_closed_doors_are_looked_at_once_each(stage: Stage) -> None:
    stage.base.pose = Pose2D(9.3, 3.0)
    stage.scene.open['kitchen'] = stage.scene.open['pantry'] = False
    stage.scene.walkers.clear()
    errand = drive(stage, [Pose2D(7.1, 8.6)], limit=40.0)
    assert errand.failure is Failure.NO_WAY


def test_what_bars_the_path_is_given_time_to_go_before_a_long_detour(stage: Stage) -> None:
    closed_at: list[float] = []
    before, way = stage.base.pose, 0.0

    def close_for_a_while() -> None:
        nonlocal before, way
        way += math.hypot(stage.base.pose.x - before.x, stage.base.pose.y - before.y)
        before = stage.base.pose
        if before.x > 3.5 and not closed_at:
            closed_at.append(stage.now)
        stage.scene.open['kitchen'] = not closed_at or stage.now > closed_at[0] + 3.0

    assert arrived(drive(stage, [Pose2D(7.0, 3.0)], meanwhile=close_for_a_while))
    assert way < 10.0, 'through the corridor it would be 14 m'


def test_without_a_pose_it_stands_and_gives_up(stage: Stage) -> None:
    errand = Errand([Pose2D(1.0, 1.0)], 0.0)
    assert errand.tick(stage.costmap, None, 0.5) == STANDING
    assert errand.ending is None
    errand.tick(stage.costmap, None, 10.5)
    assert errand.failure is Failure.LOST


@pytest.mark.long
def test_ten_goals_among_people_end_without_a_touch(stage: Stage) -> None:
    chance, reached = np.random.default_rng(11), 0
    for _ in range(10):
        goal = Pose2D(chance.uniform(-1.5, 10.0), chance.uniform(-1.5, 10.0), chance.uniform(-3.0, 3.0))
        while stage.costmap.measure_mapped(np.array([[goal.x, goal.y]]))[0] < KEEPS + 0.05:
            goal = Pose2D(chance.uniform(-1.5, 10.0), chance.uniform(-1.5, 10.0), goal.yaw)
        reached += arrived(drive(stage, [goal], limit=150.0))
    assert reached >= 9
    assert stage.nearest > 0.0
