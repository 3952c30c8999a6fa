"""A hand on the pad of the console: the robot moves only while it is held and heard in time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import Any, ParamSpec

import pytest
from helpers.patience import PATIENCE

from goalwire.apps.console.state.teleop import TWIST, TWIST_STAMPED, Teleop, twist_values

HELD = (0.5, -0.25)
STILL = (0.0, 0.0)


Arguments = ParamSpec('Arguments')


def in_loop(scenario: Callable[Arguments, Coroutine[Any, Any, None]]) -> Callable[Arguments, None]:
    """A test that runs in an event loop: silence is timed by that of the console."""

    @wraps(scenario)
    def test(*args: Arguments.args, **kwargs: Arguments.kwargs) -> None:
        asyncio.run(scenario(*args, **kwargs))

    return test


class Driven:
    """What a robot was told, and why it was stopped."""

    def __init__(self) -> None:
        self.told: list[tuple[float, float]] = []
        self.reasons: list[str] = []
        self.stopped = asyncio.Event()
        self.teleop = Teleop(self._take, self.reasons.append)

    def _take(self, ahead: float, left: float) -> None:
        self.told.append((ahead, left))
        if (ahead, left) == STILL:
            self.stopped.set()


@in_loop
async def test_it_drives_while_it_is_held_and_stops_when_it_is_let_go() -> None:
    robot = Driven()
    robot.teleop.hold(1, 0.0, *HELD)
    robot.teleop.hold(1, 0.0, 9.0, -9.0)
    robot.teleop.release()
    robot.teleop.release()
    assert robot.told == [HELD, (1.0, -1.0), STILL]
    assert not robot.reasons


@in_loop
async def test_a_hand_that_falls_silent_stops_the_robot_until_it_holds_anew() -> None:
    robot = Driven()
    robot.teleop.hold(1, 0.0, *HELD)
    await asyncio.wait_for(robot.stopped.wait(), PATIENCE)
    assert robot.reasons == ['The page fell silent: the robot was stopped.']
    robot.teleop.hold(1, 0.5, *HELD)
    assert robot.told == [HELD, STILL]
    robot.teleop.hold(2, 0.0, *HELD)
    assert robot.told[2:] == [HELD]
    robot.teleop.release()


@in_loop
async def test_a_word_that_comes_late_stops_the_robot() -> None:
    """The words of a press carry the browser's time, so the console knows how long they were on their way."""
    robot = Driven()
    robot.teleop.hold(1, 10.0, *HELD)
    robot.teleop.hold(1, 9.7, *HELD)
    robot.teleop.hold(1, 9.0, *HELD)
    assert robot.told == [HELD, HELD, STILL]
    assert 'slow' in robot.reasons[0]


@in_loop
async def test_words_of_an_earlier_press_move_nothing() -> None:
    robot = Driven()
    robot.teleop.hold(2, 0.0, *HELD)
    robot.teleop.release()
    robot.teleop.hold(1, 0.0, *HELD)
    robot.teleop.hold(2, 0.1, *HELD)
    assert robot.told == [HELD, STILL]
    assert not robot.teleop.drives


@pytest.mark.parametrize('number', [float('nan'), float('inf')])
@in_loop
async def test_what_is_no_finite_number_is_no_speed(number: float) -> None:
    robot = Driven()
    robot.teleop.hold(1, 0.0, number, number)
    robot.teleop.release()
    assert robot.told == [STILL, STILL]


@pytest.mark.parametrize('type_name', [TWIST, TWIST_STAMPED])
def test_both_types_of_velocities_are_filled(type_name: str) -> None:
    values: dict[str, Any] = twist_values(type_name, 0.3, -0.6)
    twist = values.get('twist', values)
    assert (twist['linear']['x'], twist['angular']['z']) == (0.3, -0.6)
