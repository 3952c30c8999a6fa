"""A hand on the pad of the console: the robot moves only while it is held and heard in time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import Any, ParamSpec

import pytest
from helpers.patience import PATIENCE

from goalwire.apps.console.state.teleop import TWIST, TWIST_STAMPED, Teleop, Teleops, twist_values, within

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
    """Notes the velocities that a robot gets, and why it was stopped."""

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
async def test_a_stop_is_said_again_in_case_that_it_was_lost() -> None:
    robot = Driven()
    robot.teleop.hold(1, 0.0, *HELD)
    robot.teleop.release()
    for _ in range(3):
        robot.stopped.clear()
        await asyncio.wait_for(robot.stopped.wait(), PATIENCE)
    assert robot.told == [HELD, STILL, STILL, STILL, STILL]


@in_loop
async def test_a_new_press_is_not_stopped_by_the_end_of_the_one_before() -> None:
    robot = Driven()
    robot.teleop.hold(1, 0.0, *HELD)
    robot.teleop.release()
    robot.stopped.clear()
    robot.teleop.hold(2, 0.0, *HELD)
    await asyncio.wait_for(robot.stopped.wait(), PATIENCE)
    assert robot.told == [HELD, STILL, HELD, STILL]
    assert robot.reasons == ['The page fell silent: the robot was stopped.']


@in_loop
async def test_one_hand_drives_by_a_topic_until_it_is_given_back_or_stopped() -> None:
    hands, first, second = Teleops(), Driven(), Driven()
    assert hands.take('/cmd_vel', first.teleop)
    assert not hands.take('/cmd_vel', second.teleop)
    assert hands.take('/other/cmd_vel', second.teleop)
    for robot in (first, second):
        robot.teleop.hold(1, 0.0, *HELD)
    hands.stop('STOP')
    assert [robot.told for robot in (first, second)] == [[HELD, STILL], [HELD, STILL]]
    assert first.reasons == ['STOP']
    hands.give_back(first.teleop)
    assert hands.take('/cmd_vel', second.teleop)


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
async def test_a_command_with_a_number_that_is_not_finite_moves_nothing(number: float) -> None:
    robot = Driven()
    for command in ((number, 0.0, *HELD), (1, number, *HELD), (1, 0.0, number, 0.0), (1, 0.0, 0.0, number)):
        robot.teleop.hold(*command)
    assert not robot.told


@pytest.mark.parametrize(('typed', 'limit'), [(0.5, 0.5), (-10.0, 0.0), (10.0, 2.0), (None, 0.0)])
def test_a_typed_limit_is_never_negative_nor_above_the_most(typed: float | None, limit: float) -> None:
    assert within(typed, 2.0) == limit


@pytest.mark.parametrize('type_name', [TWIST, TWIST_STAMPED])
def test_both_types_of_velocities_are_filled(type_name: str) -> None:
    values: dict[str, Any] = twist_values(type_name, 0.3, -0.6)
    twist = values.get('twist', values)
    assert (twist['linear']['x'], twist['angular']['z']) == (0.3, -0.6)
