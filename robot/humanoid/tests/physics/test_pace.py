from __future__ import annotations

import pytest

from humanoid.physics.pace import MOST_BEHIND, Pace

TICK = 0.01


def test_as_many_ticks_are_due_as_fit_the_time_that_passed() -> None:
    pace = Pace(TICK, now=100.0)
    assert pace.due(100.0) == 0
    assert pace.due(100.02) == 2
    assert pace.due(100.025) == 0
    assert pace.due(100.051) == 3


def test_rounding_loses_no_tick_in_an_hour() -> None:
    pace = Pace(TICK, now=0.1)
    assert sum(pace.due(0.1 + number * 0.02) for number in range(180_001)) == 360_000


def test_what_cannot_be_caught_up_with_is_given_up() -> None:
    pace = Pace(TICK, now=0.0)
    assert pace.due(30.0) == round(MOST_BEHIND / TICK)
    assert pace.due(30.02) == 2


def test_a_clock_set_back_brings_no_ticks() -> None:
    pace = Pace(TICK, now=50.0)
    assert pace.due(49.0) == 0
    assert pace.due(50.01) == 1


def test_the_factor_is_simulated_time_a_real_second() -> None:
    pace = Pace(TICK, now=0.0)
    for number in range(1, 60):
        pace.due(number * 0.02)
    assert pace.factor == pytest.approx(1.0, abs=0.01)
    pace.due(4.0)  # 0.2 s of the last 2.8 are caught up with
    pace.due(5.1)
    assert pace.factor < 0.2
