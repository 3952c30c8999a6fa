"""Drives along given paths through the house in simulated time, without ROS."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from helpers.house_stage import Stage

from humanoid.navigation.base import STANDING, Pose2D
from humanoid.route import follower
from humanoid.route.goals import Refused, check_path
from humanoid.route.path_errand import BLOCKED_FOR, PathErrand
from humanoid.route.planner import points_of
from humanoid.route.smoother import densify
from humanoid.route.task import Failure

INTO_THE_KITCHEN = (Pose2D(0.0, 0.0), Pose2D(4.0, 0.95), Pose2D(6.4, 0.95, 1.5))


@pytest.fixture
def stage() -> Stage:
    return Stage()


def follow(
    stage: Stage, poses: Sequence[Pose2D], meanwhile: Callable[[], None] = lambda: None
) -> tuple[PathErrand, float]:
    """Follow the path to its end; return the task, and how far off the path the robot was at most, in m."""
    task, line, off = PathErrand(poses, stage.now), densify(points_of(poses)), [0.0]

    def watch() -> None:
        off.append(float(np.hypot(line[:, 0] - stage.base.pose.x, line[:, 1] - stage.base.pose.y).min()))
        meanwhile()

    stage.carry_out(task, 90.0, watch)
    return task, max(off)


def arrived(task: PathErrand) -> bool:
    return task.ending is not None and task.ending.success


def test_it_follows_the_path_to_its_end_and_turns_as_the_last_pose_does(stage: Stage) -> None:
    task, off = follow(stage, INTO_THE_KITCHEN)
    assert arrived(task), task.ending
    assert follower.has_arrived(stage.base.pose, INTO_THE_KITCHEN[-1])
    assert off < 0.2
    assert stage.nearest > 0.0


@pytest.mark.parametrize(
    ('path', 'seconds'),
    [
        ((Pose2D(), Pose2D(2.0, 0.0), Pose2D(2.0, 1.2), Pose2D(0.0, 1.2), Pose2D()), 9.0),
        ((Pose2D(), Pose2D(2.0, 0.0), Pose2D()), 6.0),
    ],
    ids=['a round', 'there and back'],
)
def test_a_path_that_ends_where_it_begins_is_followed_all_the_way(
    stage: Stage, path: Sequence[Pose2D], seconds: float
) -> None:
    seen: list[Pose2D] = []
    task, off = follow(stage, path, lambda: seen.append(stage.base.pose))
    assert arrived(task), task.ending
    assert stage.now > seconds
    assert max(pose.x for pose in seen) > 1.8
    assert off < 0.25


def test_a_robot_in_the_middle_of_the_path_goes_on_from_there(stage: Stage) -> None:
    stage.base.pose = Pose2D(2.0, 0.3)
    told: list[float] = []
    task = PathErrand((Pose2D(), Pose2D(4.0, 0.0)), 0.0)
    stage.carry_out(task, 30.0, lambda: told.append(task.left))
    assert arrived(task), task.ending
    assert 2.0 < told[0] < 3.0
    assert told[-1] == 0.0


def test_it_waits_before_what_stands_on_the_path_and_goes_on_once_that_is_gone(stage: Stage) -> None:
    stage.scene.open['kitchen'] = False
    stood = [0]

    def open_after_a_while() -> None:
        stood[0] += stage.base.velocity == STANDING and stage.base.pose.x > 4.0
        stage.scene.open['kitchen'] = stood[0] > 60  # ticks: 3 s

    task, _ = follow(stage, INTO_THE_KITCHEN, open_after_a_while)
    assert stood[0] > 60
    assert arrived(task), task.ending
    assert stage.nearest > 0.0


def test_it_gives_up_before_what_stays_on_the_path_with_the_place(stage: Stage) -> None:
    stage.scene.open['kitchen'] = False
    task, _ = follow(stage, INTO_THE_KITCHEN)
    assert task.failure is Failure.BLOCKED
    assert task.ending is not None
    assert 'Blocked: something stands on the path near (5.' in task.ending.message
    assert stage.now > BLOCKED_FOR
    assert stage.nearest > 0.0


def test_without_a_pose_it_stands_and_gives_up(stage: Stage) -> None:
    task = PathErrand(INTO_THE_KITCHEN, 0.0)
    assert task.tick(stage.costmap, None, 0.5) == STANDING
    assert task.ending is None
    task.tick(stage.costmap, None, 10.5)
    assert task.failure is Failure.LOST


@pytest.mark.parametrize(
    ('path', 'why'),
    [
        ((), 'the path is empty'),
        ((Pose2D(3.0, 1.0), Pose2D(4.0, 1.0)), 'the robot is 3.16 m from the path; 1.5 m is the most'),
        ((Pose2D(), Pose2D(5.0, 2.5), Pose2D(7.0, 2.5)), 'through a thing of the map, .* near .5.1, 2.5. m'),
        ((Pose2D(), Pose2D(0.0, -9.0)), 'through a thing of the map, or off the map'),
        ([Pose2D(), Pose2D(4.0, 0.0)] * 80, 'the path is 636 m long; 500 m is the most'),
        ([Pose2D()] * 10_001, 'the path has 10001 poses; 10000 are the most'),
    ],
    ids=['empty', 'elsewhere', 'through a wall', 'out of the house', 'too long', 'too many poses'],
)
def test_a_path_that_cannot_be_followed_is_refused_with_the_reason(
    stage: Stage, path: Sequence[Pose2D], why: str
) -> None:
    with pytest.raises(Refused, match=why):
        check_path(stage.costmap, Pose2D(), path)
    check_path(stage.costmap, Pose2D(), INTO_THE_KITCHEN)
