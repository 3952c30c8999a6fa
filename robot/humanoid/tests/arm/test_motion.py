from __future__ import annotations

import pytest

from humanoid.arm.motion import PATIENCE, ArmMotion

A, B = 'left_arm_shoulder', 'left_arm_elbow'
MOTION = ArmMotion([A, B], start=[0.0, 0.0], target=[1.0, 0.2], duration=2.0, began=100.0)


@pytest.mark.parametrize(
    ('a', 'fraction'), [(0.0, 0.0), (0.25, 0.25), (1.0, 1.0), (-0.5, 0.0), (1.25, 0.75), (3.0, 0.0)]
)
def test_the_longest_motion_counts(a: float, fraction: float) -> None:
    assert MOTION.fraction_done({A: a, B: 0.0}) == pytest.approx(fraction)


def test_a_motion_of_no_length_is_done() -> None:
    still = ArmMotion([A], start=[0.5], target=[0.5], duration=2.0, began=100.0)
    assert still.fraction_done({A: 0.5}) == 1.0
    assert still.arrived({A: 0.5})


def test_it_has_arrived_once_every_joint_has() -> None:
    assert not MOTION.arrived({A: 1.0, B: 0.0})
    assert MOTION.arrived({A: 0.995, B: 0.205})


def test_it_has_not_failed_while_there_is_time() -> None:
    end = 100.0 + MOTION.duration + PATIENCE
    assert MOTION.failure({A: 0.0, B: 0.0}, seen=end) is None


def test_it_fails_when_the_joints_are_late_and_says_which() -> None:
    late = 100.0 + MOTION.duration + PATIENCE + 0.01
    failure = MOTION.failure({A: 0.4, B: 0.2}, seen=late)
    assert failure is not None
    assert f'{A} by 0.600 rad' in failure
