"""The guard lets the base go where there is room, and nowhere else."""

from __future__ import annotations

import math

import numpy as np

from humanoid.clock import NANOSECONDS, time_msg
from humanoid.model import BASE
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D
from humanoid.navigation.drift import Drift, DriftSpec
from humanoid.navigation.guard import MARGIN, Guard
from humanoid.world.messages import laser_scan

AHEAD = 180  # the beam straight ahead
FORWARD = Velocity2D(0.8)


def guard(ahead: float, at: float = 10.0) -> Guard:
    """A guard that has seen something `ahead` m before the scanner, and nothing else."""
    ranges = np.full(360, np.inf)
    ranges[AHEAD - 3 : AHEAD + 4] = ahead
    made = Guard()
    made.note_pose(at, Pose2D())
    made.hear(laser_scan(ranges, 'laser', time_msg(round(at * NANOSECONDS)), 0.1))
    return made


def test_where_there_is_room_it_changes_nothing() -> None:
    assert guard(3.0).limit(FORWARD, Pose2D(), 10.1) == FORWARD


def test_it_slows_down_before_something_and_stops_in_front_of_it() -> None:
    near = guard(0.5).limit(FORWARD, Pose2D(), 10.1)
    assert 0.0 < near.x < FORWARD.x
    assert guard(BASE.radius + MARGIN - 0.07).limit(FORWARD, Pose2D(), 10.1) == STANDING


def test_it_stops_the_base_clear_of_what_it_walks_at() -> None:
    """At full speed towards something, a step at a time: it never touches."""
    watch, pose = guard(1.5), Pose2D()
    for step in range(200):
        velocity = watch.limit(FORWARD, pose, 10.0 + (step % 20) / 50)
        pose = Pose2D(pose.x + velocity.x * 0.02, 0.0, 0.0)
    left = 1.5 + 0.07 - pose.x - BASE.radius
    assert 0.0 < left < 0.15


def test_away_from_something_and_on_the_spot_it_may_move() -> None:
    near = guard(BASE.radius - 0.07)
    back, turn = Velocity2D(-0.3), Velocity2D(yaw=1.0)
    assert near.limit(back, Pose2D(), 10.1) == back
    assert near.limit(turn, Pose2D(), 10.1) == turn


def test_without_a_scan_or_with_an_old_one_nothing_moves() -> None:
    assert Guard().limit(FORWARD, Pose2D(), 1.0) == STANDING
    assert guard(5.0).limit(FORWARD, Pose2D(), 10.6) == STANDING


def test_a_scan_is_placed_where_it_was_taken() -> None:
    watch = guard(2.0, at=10.0)
    moved = Pose2D(1.5, 0.0, 0.0)
    assert watch.limit(FORWARD, moved, 10.4).x < FORWARD.x
    assert watch.limit(FORWARD, Pose2D(1.5, 0.0, math.pi), 10.4) == FORWARD


def test_drift_counts_the_way_and_turns_wrong_by_its_shares() -> None:
    drift = Drift(DriftSpec(way=0.1, veer=0.05), Pose2D())
    for step in range(1, 101):
        counted = drift.follow(Pose2D(step / 100.0, 0.0, 0.0))
    assert math.hypot(counted.x, counted.y) < 1.1
    assert counted.x > 1.09
    assert counted.yaw == math.remainder(0.05, math.tau) or abs(counted.yaw - 0.05) < 1e-9


def test_without_drift_the_count_is_exact() -> None:
    drift = Drift(DriftSpec(), Pose2D())
    assert drift.follow(Pose2D(0.8, 0.6, 0.1)) == Pose2D(0.8, 0.6, 0.1)
