from __future__ import annotations

import math

import pytest

from humanoid.model import BASE
from humanoid.navigation.base import STANDING, Base, Pose2D, turn_between, yaw_of

TICK = 0.02


def drive(base: Base, target: Pose2D, seconds: float) -> int:
    """Steps until arrival, or as many as fit into the time."""
    base.drive_to(target)
    for step in range(round(seconds / TICK)):
        base.step(TICK)
        if base.arrived:
            return step + 1
    return round(seconds / TICK)


def test_it_arrives_exactly_and_as_soon_as_its_speed_allows() -> None:
    base = Base()
    target = Pose2D(1.2, 1.6)
    steps = drive(base, target, 10.0)
    assert base.pose == target
    assert steps == pytest.approx(2.0 / BASE.max_speed / TICK, abs=1)


def test_it_drives_straight_and_never_faster_than_its_limit() -> None:
    base = Base()
    target = Pose2D(3.0, 4.0)
    base.drive_to(target)
    before = base.pose
    while not base.arrived:
        base.step(TICK)
        moved = math.hypot(base.pose.x - before.x, base.pose.y - before.y)
        assert moved <= BASE.max_speed * TICK + 1e-9
        assert base.pose.y == pytest.approx(base.pose.x * 4.0 / 3.0)
        before = base.pose


def test_a_long_step_ends_at_the_target_and_not_beyond() -> None:
    base = Base()
    base.drive_to(Pose2D(0.1, 0.0))
    base.step(60.0)
    assert base.pose == Pose2D(0.1, 0.0)


def test_it_turns_the_short_way_at_a_bounded_rate() -> None:
    base = Base()
    base.pose = Pose2D(yaw=3.0)
    base.drive_to(Pose2D(yaw=-3.0))
    base.step(TICK)
    assert base.velocity.yaw == pytest.approx(BASE.max_turn_rate)
    assert base.pose.yaw > 3.0


def test_velocity_is_told_in_the_frame_of_the_base() -> None:
    base = Base()
    base.pose = Pose2D(yaw=math.pi / 2)
    base.drive_to(Pose2D(0.0, 2.0, math.pi / 2))
    base.step(TICK)
    assert base.velocity.x == pytest.approx(BASE.max_speed)
    assert base.velocity.y == pytest.approx(0.0, abs=1e-9)


def test_stopping_is_immediate_and_lasts() -> None:
    base = Base()
    drive(base, Pose2D(5.0, 0.0), 1.0)
    base.stop()
    there = base.pose
    base.step(TICK)
    assert (base.pose, base.velocity) == (there, STANDING)
    assert not base.arrived


def test_a_new_target_replaces_the_old_one() -> None:
    base = Base()
    drive(base, Pose2D(5.0, 0.0), 1.0)
    drive(base, Pose2D(0.0, 1.0), 10.0)
    assert base.pose == Pose2D(0.0, 1.0)


def test_standing_on_the_target_is_having_arrived_after_one_step() -> None:
    base = Base()
    assert drive(base, Pose2D(), 1.0) == 1


@pytest.mark.parametrize('elapsed', [0.0, -1.0])
def test_no_time_no_motion(elapsed: float) -> None:
    base = Base()
    base.drive_to(Pose2D(1.0, 0.0))
    base.step(elapsed)
    assert base.pose == Pose2D()


@pytest.mark.parametrize(
    ('start', 'end', 'turn'),
    [(0.0, 1.0, 1.0), (3.0, -3.0, math.tau - 6.0), (-3.0, 3.0, 6.0 - math.tau), (0.0, 7.0, 7.0 - math.tau)],
)
def test_turns_take_the_short_way(start: float, end: float, turn: float) -> None:
    assert turn_between(start, end) == pytest.approx(turn)


@pytest.mark.parametrize('length', [0.5, 1.0, 3.0])
def test_a_quaternion_of_any_length_gives_its_heading(length: float) -> None:
    yaw = yaw_of(0.0, 0.0, length * math.sin(0.4), length * math.cos(0.4))
    assert yaw == pytest.approx(0.8)


def test_an_all_zero_quaternion_means_no_turn() -> None:
    assert yaw_of(0.0, 0.0, 0.0, 0.0) == 0.0
