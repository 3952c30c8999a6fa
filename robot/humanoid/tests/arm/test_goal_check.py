from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import pytest

from humanoid.arm.goal_check import refusal
from humanoid.model import JOINT_BY_NAME

HERE = {name: joint.home for name, joint in JOINT_BY_NAME.items()}
SHOULDER = 'left_arm_shoulder'


def judge(
    names: Sequence[str],
    positions: Sequence[float],
    duration: float = 2.0,
    here: Mapping[str, float] = HERE,
    busy: Collection[str] = (),
) -> str | None:
    return refusal(names, positions, duration, here=here, busy=busy, joints=JOINT_BY_NAME)


def test_a_sound_goal_is_taken() -> None:
    assert judge([SHOULDER, 'left_arm_elbow'], [1.5, 1.0]) is None


def test_a_joint_beyond_its_limits_is_refused_by_name() -> None:
    assert judge([SHOULDER], [3.0]) == (
        'left_arm_shoulder cannot go to 3.0 rad; its limits are -2.9 to 2.9 rad'
    )


@pytest.mark.parametrize(
    ('names', 'positions', 'complaint'),
    [
        ([], [], 'no joint'),
        (['tail'], [0.0], "unknown joint 'tail'"),
        ([SHOULDER], [], '0 positions for 1 joints'),
        ([SHOULDER, SHOULDER], [0.0, 0.1], 'named twice'),
        ([SHOULDER], [math.nan], 'nan'),
    ],
)
def test_a_malformed_goal_is_refused(names: list[str], positions: list[float], complaint: str) -> None:
    assert complaint in str(judge(names, positions))


@pytest.mark.parametrize(
    'duration', [0.0, -0.0, -1.0, 5e-324, 0.009, 3601.0, 3e9, 1e308, math.nan, math.inf, -math.inf]
)
def test_a_duration_outside_its_bounds_is_refused(duration: float) -> None:
    assert 'duration' in str(judge([SHOULDER], [1.0], duration))


def test_a_goal_that_outruns_the_velocity_limit_is_refused() -> None:
    assert 'would need 2.40 rad/s, its limit is 2.0 rad/s' in str(judge([SHOULDER], [2.9], 1.0))


def test_a_joint_that_moves_for_another_goal_is_refused() -> None:
    assert 'moving for another goal' in str(judge([SHOULDER], [1.0], busy={SHOULDER}))


def test_a_joint_that_nobody_has_seen_yet_is_refused() -> None:
    assert 'no joint state has shown it' in str(judge([SHOULDER], [1.0], here={}))
