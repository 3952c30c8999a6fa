from __future__ import annotations

import math

import pytest

from humanoid.navigation.goal_check import refusal

LEVEL = (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize('frame', ['', 'odom'])
def test_a_sound_goal_is_taken(frame: str) -> None:
    assert refusal(frame, (1.0, -2.0, 0.0), LEVEL, 30.0) is None


def test_a_target_above_the_floor_is_taken_as_in_the_chapter() -> None:
    assert refusal('', (1.0, 2.0, 0.5), LEVEL, 30.0) is None


@pytest.mark.parametrize(
    ('position', 'complaint'),
    [
        ((0.0, 0.0, -1e-9), 'below the floor'),
        ((math.nan, 0.0, 0.0), 'not within 1000 m'),
        ((0.0, math.inf, 0.0), 'not within 1000 m'),
        ((1000.1, 0.0, 0.0), 'not within 1000 m'),
        ((0.0, -1e308, 0.0), 'not within 1000 m'),
        ((0.0, 0.0, math.nan), 'not within 1000 m'),
    ],
)
def test_a_target_that_is_nowhere_is_refused(position: tuple[float, float, float], complaint: str) -> None:
    assert complaint in str(refusal('', position, LEVEL, 30.0))


@pytest.mark.parametrize('place', range(4))
@pytest.mark.parametrize('number', [math.nan, math.inf, -1e308, 1e155])
def test_an_orientation_that_no_heading_follows_from_is_refused(place: int, number: float) -> None:
    orientation = [0.0, 0.0, 0.0, 1.0]
    orientation[place] = number
    x, y, z, w = orientation
    assert 'orientation' in str(refusal('', (0.0, 0.0, 0.0), (x, y, z, w), 30.0))


@pytest.mark.parametrize('timeout', [0.0, -1.0, 86401.0, 1e308, math.nan, math.inf, -math.inf])
def test_a_timeout_outside_its_bounds_is_refused(timeout: float) -> None:
    assert 'timeout' in str(refusal('', (0.0, 0.0, 0.0), LEVEL, timeout))


def test_a_frame_that_the_base_does_not_know_is_refused() -> None:
    assert "'moon'" in str(refusal('moon', (0.0, 0.0, 0.0), LEVEL, 30.0))
