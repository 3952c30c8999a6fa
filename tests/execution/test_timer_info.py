from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import pytest
from helpers.execution import SmallContext, SmallNode

from goalwire.execution.clock import Clock, ROSClock
from goalwire.execution.single_threaded import SingleThreadedExecutor
from goalwire.execution.timer import Timer, TimerInfo, taking_info
from goalwire.rules.time import ClockType, Time

if TYPE_CHECKING:
    from collections.abc import Callable


class Robot:
    def nothing(self) -> None: ...
    def required(self, info: object) -> object:
        return info

    def annotated(self, how: int = 3, *, when: TimerInfo | None = None, info: TimerInfo) -> object:
        return (how, when, info)


class Callable0:
    def __call__(self) -> None: ...


class Callable1:
    def __call__(self, info: TimerInfo) -> TimerInfo:
        return info


def default(name: str = 'x') -> str:
    return name


def quoted(number: int = 1, info: 'TimerInfo | None' = None) -> None: ...  # noqa: UP037


def exact(number: int = 1, info: TimerInfo = TimerInfo()) -> object:  # noqa: B008
    return (number, info)


def anything(*args: object, **kwargs: object) -> None: ...


@pytest.mark.parametrize(
    'callback',
    [
        Robot().nothing,
        Callable0(),
        default,
        quoted,
        anything,
        print,
        partial(default, 'y'),
        lambda name='x': name,
        None,
        3,
    ],
)
def test_a_callback_that_asks_for_nothing_gets_nothing(callback: object) -> None:
    assert taking_info(callback) is None


@pytest.mark.parametrize(
    ('callback', 'expected'),
    [
        (lambda info: info, lambda info: info),
        (Robot().required, lambda info: info),
        (Callable1(), lambda info: info),
        (exact, lambda info: (1, info)),
        (Robot().annotated, lambda info: (3, None, info)),
        (partial(Robot().annotated, 5), lambda info: (5, None, info)),
    ],
)
def test_a_callback_that_asks_gets_the_info(
    callback: object, expected: Callable[[TimerInfo], object]
) -> None:
    info = TimerInfo(expected_call_time=1, actual_call_time=2)
    given = taking_info(callback)
    assert given is not None
    assert given(info) == expected(info)


def test_an_info_holds_times_of_the_clock() -> None:
    info = TimerInfo(expected_call_time=5, actual_call_time=7, clock_type=ClockType.ROS_TIME)
    assert info.expected_call_time == Time(nanoseconds=5, clock_type=ClockType.ROS_TIME)
    assert info.actual_call_time == Time(nanoseconds=7, clock_type=ClockType.ROS_TIME)


@pytest.mark.parametrize(
    ('arguments', 'error', 'message'),
    [
        ({'clock_type': 1}, TypeError, 'Clock type must be a ClockType enum'),
        ({'expected_call_time': -1}, ValueError, 'call time values must not be negative'),
        ({'actual_call_time': -1}, ValueError, 'call time values must not be negative'),
    ],
)
def test_an_info_of_impossible_times_is_refused(
    arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        TimerInfo(**arguments)


def test_a_timer_tells_when_it_was_due_and_when_it_came(context: SmallContext) -> None:
    node, clock, seen = SmallNode(), ROSClock(), list[TimerInfo]()
    clock._set_ros_time_is_active(True)
    timer = Timer(seen.append, None, 10**9, clock, work_queue=node.work_queue)
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        clock.set_ros_time_override(Time(seconds=2.5, clock_type=ClockType.ROS_TIME))
        executor.spin_once(0)
    timer.destroy()
    [info] = seen
    assert info.expected_call_time == Time(seconds=1, clock_type=ClockType.ROS_TIME)
    assert info.actual_call_time == Time(seconds=2.5, clock_type=ClockType.ROS_TIME)


def test_another_callback_may_ask_for_less() -> None:
    timer = Timer(lambda _: None, None, 10**9, Clock())
    assert timer._with_info is not None
    timer.callback = lambda: None
    assert timer._with_info is None
