"""Somebody drives the robot through the house by hand, in simulated time and without ROS."""

from __future__ import annotations

import math

import pytest
from helpers.house_stage import TICK, Stage

from humanoid.model import BASE
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D
from humanoid.route.task import Failure
from humanoid.route.teleop_errand import TeleopErrand

AHEAD = Velocity2D(0.5)


@pytest.fixture
def stage() -> Stage:
    return Stage()


def test_it_moves_as_it_is_told_and_stops_half_a_second_after_the_last_velocity(stage: Stage) -> None:
    task = TeleopErrand(0.0, 0.0)
    task.hear(Velocity2D(0.5, 0.1, 0.2), 0.0)
    assert task.tick(stage.costmap, Pose2D(), 0.4) == Velocity2D(0.5, 0.1, 0.2)
    assert task.tick(stage.costmap, Pose2D(), 0.6) == STANDING
    task.hear(Velocity2D(math.nan), 0.7)
    assert task.tick(stage.costmap, Pose2D(), 0.7) == STANDING
    assert task.ending is None


def test_it_is_stopped_before_a_thing_that_only_the_map_shows(stage: Stage) -> None:
    """The step in the workshop, whose edge is at x = 9.75 m, is lower than the scanner."""
    stage.base.pose = Pose2D(8.6, 9.9)
    task = TeleopErrand(6.0, 0.0)
    stage.carry_out(task, 10.0, lambda: task.hear(AHEAD, stage.now))
    assert 9.2 < stage.base.pose.x < 9.75 - BASE.radius
    assert stage.nearest > 0.0


def test_it_is_stopped_before_a_closed_door(stage: Stage) -> None:
    stage.scene.open['kitchen'] = False
    stage.base.pose = Pose2D(4.0, 0.95)
    task = TeleopErrand(6.0, 0.0)
    stage.carry_out(task, 10.0, lambda: task.hear(AHEAD, stage.now))
    assert 4.8 < stage.base.pose.x < 5.5 - BASE.radius
    assert stage.nearest > 0.0


def test_it_fails_once_its_time_is_over(stage: Stage) -> None:
    task = TeleopErrand(2.0, 0.0)
    stage.carry_out(task, 10.0)
    assert stage.now == pytest.approx(2.0, abs=3 * TICK)
    assert task.failure is Failure.LATE
    assert task.ending is not None
    assert task.ending.message == 'Assisted teleop is over: it was allowed for 2 s'


@pytest.mark.parametrize('allowed', [0.0, -1.0])
def test_without_a_time_it_goes_on_until_it_is_finished(stage: Stage, allowed: float) -> None:
    task = TeleopErrand(allowed, 0.0)
    stage.carry_out(task, 30.0)
    assert stage.now == pytest.approx(30.0)
    task.finish()
    assert task.ending is not None
    assert task.ending.success
    assert task.tick(stage.costmap, Pose2D(), 31.0) == STANDING


def test_without_a_pose_it_stands_and_gives_up(stage: Stage) -> None:
    task = TeleopErrand(60.0, 0.0)
    task.hear(AHEAD, 10.4)
    assert task.tick(stage.costmap, None, 10.5) == STANDING
    assert task.failure is Failure.LOST
