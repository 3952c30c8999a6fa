"""Time and Duration against what a real rclpy was measured to answer."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest

from goalwire.rules.time import S_TO_NS, ClockType, Duration, Infinite, Time

ROS = ClockType.ROS_TIME
UNINITIALIZED = ClockType.UNINITIALIZED
LONGEST = 2**63 - 1

Expression = Callable[[], object]
# Wrong types on purpose: mypy must not judge these.
AnyTime: Any = Time
AnyDuration: Any = Duration
messages: Any = import_module('builtin_interfaces.msg')


@pytest.mark.parametrize(
    ('expression', 'text'),
    [
        (Time, 'Time(nanoseconds=0, clock_type=SYSTEM_TIME)'),
        (lambda: Time(seconds=1, nanoseconds=5), 'Time(nanoseconds=1000000005, clock_type=SYSTEM_TIME)'),
        (lambda: Time(clock_type=UNINITIALIZED), 'Time(nanoseconds=0, clock_type=UNINITIALIZED)'),
        (
            lambda: Time(seconds=3, clock_type=ROS) + Duration(seconds=1),
            'Time(nanoseconds=4000000000, clock_type=ROS_TIME)',
        ),
        (
            lambda: Time(seconds=3) - Duration(seconds=1),
            'Time(nanoseconds=2000000000, clock_type=SYSTEM_TIME)',
        ),
        (lambda: Time(seconds=3) - Time(seconds=5), 'Duration(nanoseconds=-2000000000)'),
        (Duration, 'Duration(nanoseconds=0)'),
        (lambda: Duration(seconds=1, nanoseconds=5), 'Duration(nanoseconds=1000000005)'),
        (lambda: Duration(nanoseconds=-(2**63)), 'Duration(nanoseconds=-9223372036854775808)'),
        (lambda: Infinite, 'Duration(nanoseconds=9223372036854775807)'),
    ],
)
def test_a_time_value_shows_itself_as_in_rclpy(expression: Expression, text: str) -> None:
    assert repr(expression()) == text


def test_a_duration_prints_its_nanoseconds() -> None:
    assert str(Duration(seconds=-1.5)) == '-1500000000 nanoseconds'


@pytest.mark.parametrize(
    ('value', 'nanoseconds'),
    [
        (Time(seconds=1.5), 1_500_000_000),
        (Time(seconds=0.1), 100_000_000),
        (Time(seconds=1.1), 1_100_000_000),
        (Time(nanoseconds=1.9), 1),
        (Time(nanoseconds=LONGEST), LONGEST),
        (Duration(seconds=0.1), 100_000_000),
        (Duration(seconds=1.1), 1_100_000_000),
        (Duration(seconds=-0.5), -500_000_000),
        (Duration(nanoseconds=1.9), 1),
        (Duration(nanoseconds=-1.9), -1),
        (Infinite, LONGEST),
    ],
)
def test_nanoseconds_are_whole_and_cut_off_towards_zero(value: Time | Duration, nanoseconds: int) -> None:
    assert value.nanoseconds == nanoseconds
    assert type(value.nanoseconds) is int


@pytest.mark.parametrize(
    ('expression', 'error', 'text'),
    [
        (lambda: Time(seconds=1, nanoseconds=-1), ValueError, 'Nanoseconds value must not be negative'),
        (lambda: Time(seconds=-1), ValueError, 'Seconds value must not be negative'),
        (lambda: AnyTime(seconds='1'), TypeError, "'<' not supported between instances of 'str' and 'int'"),
        (
            lambda: Time(seconds=2**40),
            OverflowError,
            'Total nanoseconds value is too large to store in C time point.',
        ),
        (
            lambda: Time(nanoseconds=2**63),
            OverflowError,
            'Total nanoseconds value is too large to store in C time point.',
        ),
        (lambda: AnyTime(clock_type=1), TypeError, 'Clock type must be a ClockType enum'),
        (lambda: AnyTime(clock_type='x'), TypeError, 'Clock type must be a ClockType enum'),
        (lambda: AnyTime(5), TypeError, 'Time.__init__() takes 1 positional argument but 2 were given'),
        (lambda: hash(Time()), TypeError, "unhashable type: 'Time'"),
        (
            lambda: setattr(Time(), 'nanoseconds', 1),
            AttributeError,
            "property 'nanoseconds' of 'Time' object has no setter",
        ),
        (
            lambda: Duration(seconds=2**40),
            OverflowError,
            'Total nanoseconds value is too large to store in C duration.',
        ),
        (
            lambda: Duration(nanoseconds=2**63),
            OverflowError,
            'Total nanoseconds value is too large to store in C duration.',
        ),
        (
            lambda: AnyDuration(1),
            TypeError,
            'Duration.__init__() takes 1 positional argument but 2 were given',
        ),
        (lambda: AnyDuration(seconds='1'), ValueError, "seconds must be a number, got '1'"),
        (lambda: Duration(seconds=float('nan')), ValueError, 'cannot convert float NaN to integer'),
        (lambda: Duration(seconds=float('inf')), OverflowError, 'cannot convert float infinity to integer'),
        (lambda: hash(Duration()), TypeError, "unhashable type: 'Duration'"),
    ],
)
def test_a_value_that_cannot_be_is_refused_as_in_rclpy(
    expression: Expression, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        expression()
    assert str(caught.value) == text


def no_operator(sign: str, left: str, right: str) -> str:
    return f"unsupported operand type(s) for {sign}: '{left}' and '{right}'"


def no_order(left: str, right: str) -> str:
    return f"'<' not supported between instances of '{left}' and '{right}'"


@pytest.mark.parametrize(
    ('expression', 'error', 'text'),
    [
        (lambda: AnyTime(seconds=1) + Time(seconds=1), TypeError, no_operator('+', 'Time', 'Time')),
        (lambda: AnyTime(seconds=1) + 1, TypeError, no_operator('+', 'Time', 'int')),
        (lambda: 1 + AnyTime(), TypeError, no_operator('+', 'int', 'Time')),
        (lambda: AnyTime(seconds=3) - 1, TypeError, no_operator('-', 'Time', 'int')),
        (lambda: Time(seconds=1) - Duration(seconds=2), ValueError, 'Subtraction leads to negative time.'),
        (lambda: Time() - Duration(nanoseconds=1), ValueError, 'Subtraction leads to negative time.'),
        (
            lambda: Time(seconds=3, clock_type=ROS) - Time(seconds=1),
            TypeError,
            "Can't subtract times with different clock types",
        ),
        (
            lambda: Time(nanoseconds=LONGEST) + Duration(nanoseconds=1),
            OverflowError,
            'Addition leads to overflow in C storage.',
        ),
        (
            lambda: Time(seconds=1) + Duration(seconds=-2),
            ValueError,
            'Nanoseconds value must not be negative',
        ),
        (lambda: AnyTime(seconds=1) < 1, TypeError, no_order('Time', 'int')),
        (lambda: AnyTime(seconds=1) < Duration(seconds=2), TypeError, no_order('Time', 'Duration')),
        (lambda: AnyTime(seconds=1) < None, TypeError, no_order('Time', 'NoneType')),
        (lambda: -AnyTime(), TypeError, "bad operand type for unary -: 'Time'"),
        (lambda: AnyDuration(seconds=1) + 1, TypeError, no_operator('+', 'Duration', 'int')),
        (lambda: AnyDuration(seconds=1) - 1, TypeError, no_operator('-', 'Duration', 'int')),
        (lambda: AnyDuration(seconds=1) * None, TypeError, no_operator('*', 'Duration', 'NoneType')),
        (lambda: AnyDuration(seconds=1) / 2, TypeError, no_operator('/', 'Duration', 'int')),
        (lambda: -AnyDuration(seconds=1), TypeError, "bad operand type for unary -: 'Duration'"),
        (lambda: abs(AnyDuration(seconds=-1)), TypeError, "bad operand type for abs(): 'Duration'"),
        (lambda: AnyDuration(seconds=1) < 1, TypeError, no_order('Duration', 'int')),
    ],
)
def test_arithmetic_that_makes_no_sense_is_refused_as_in_rclpy(
    expression: Expression, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        expression()
    assert str(caught.value) == text


@pytest.mark.parametrize(
    'expression',
    [
        lambda: Time(seconds=1) == Time(seconds=1, clock_type=ROS),
        lambda: Time(seconds=1) != Time(seconds=1, clock_type=ROS),
        lambda: Time(seconds=1) < Time(seconds=1, clock_type=ROS),
        lambda: Time(seconds=1) >= Time(seconds=1, clock_type=ROS),
    ],
)
def test_times_of_different_clocks_are_never_compared(expression: Expression) -> None:
    with pytest.raises(TypeError, match=r"^Can't compare times with different clock types\n"):
        expression()


def test_times_are_ordered() -> None:
    early, late = Time(seconds=1), Time(seconds=2)
    assert early == Time(nanoseconds=S_TO_NS)
    assert early != late
    assert early <= late
    assert late > early
    assert sorted([late, early]) == [early, late]
    assert max(late, early).nanoseconds == 2 * S_TO_NS


def test_durations_are_ordered() -> None:
    assert Duration(seconds=-1) < Duration() <= Duration(nanoseconds=0) < Infinite


def test_a_time_value_equals_nothing_of_another_kind() -> None:
    assert Time(seconds=1) != 1
    assert Time(seconds=1) != Duration(seconds=1)
    assert Duration(seconds=1) != 1


def test_a_time_is_true_even_at_zero() -> None:
    assert bool(AnyTime()) is True


def test_a_duration_may_stand_before_the_time_it_is_added_to() -> None:
    assert Duration(seconds=1) + Time(seconds=2) == Time(seconds=3)


def test_a_time_splits_into_seconds_and_nanoseconds() -> None:
    assert Time(seconds=1, nanoseconds=2_500_000_000).seconds_nanoseconds() == (3, 500_000_000)


def test_clock_types_carry_the_numbers_of_rcl() -> None:
    assert {kind.name: kind.value for kind in ClockType} == {
        'UNINITIALIZED': 0,
        'ROS_TIME': 1,
        'SYSTEM_TIME': 2,
        'STEADY_TIME': 3,
    }


def test_the_c_duration_tells_the_same_span() -> None:
    assert Duration(seconds=2).get_c_duration().nanoseconds == 2 * S_TO_NS


@pytest.mark.parametrize(
    ('expression', 'text'),
    [
        (lambda: Time(seconds=3, nanoseconds=4).to_msg(), 'Time(sec=3, nanosec=4)'),
        (lambda: Time(seconds=2**31).to_msg(), 'Time(sec=2147483648, nanosec=0)'),
        (lambda: Duration(seconds=1.5).to_msg(), 'Duration(sec=1, nanosec=500000000)'),
        (lambda: Duration(seconds=-1.5).to_msg(), 'Duration(sec=-2, nanosec=500000000)'),
        (lambda: Duration(nanoseconds=-1).to_msg(), 'Duration(sec=-1, nanosec=999999999)'),
        (lambda: Duration(seconds=2**31).to_msg(), 'Duration(sec=2147483648, nanosec=0)'),
        (Infinite.to_msg, 'Duration(sec=9223372036, nanosec=854775807)'),
        (
            lambda: Time.from_msg(messages.Time(sec=3, nanosec=4)),
            'Time(nanoseconds=3000000004, clock_type=ROS_TIME)',
        ),
        (
            lambda: Time.from_msg(messages.Time(sec=3, nanosec=4), clock_type=ClockType.SYSTEM_TIME),
            'Time(nanoseconds=3000000004, clock_type=SYSTEM_TIME)',
        ),
        (
            lambda: Duration.from_msg(messages.Duration(sec=-2, nanosec=500_000_000)),
            'Duration(nanoseconds=-1500000000)',
        ),
    ],
)
def test_messages_and_time_values_turn_into_each_other(expression: Expression, text: str) -> None:
    assert repr(expression()).removeprefix('builtin_interfaces.msg.') == text


@pytest.mark.parametrize(
    ('expression', 'error', 'text'),
    [
        (
            lambda: Time.from_msg(messages.Duration(sec=3)),
            TypeError,
            'Must pass a builtin_interfaces.msg.Time object',
        ),
        (lambda: AnyTime.from_msg(1), TypeError, 'Must pass a builtin_interfaces.msg.Time object'),
        (
            lambda: Time.from_msg(messages.Time(sec=-3, nanosec=4)),
            ValueError,
            'Seconds value must not be negative',
        ),
        (
            lambda: Duration.from_msg(messages.Time(sec=1)),
            TypeError,
            'Must pass a builtin_interfaces.msg.Duration object',
        ),
        (lambda: AnyDuration.from_msg(1), TypeError, 'Must pass a builtin_interfaces.msg.Duration object'),
    ],
)
def test_only_the_right_message_becomes_a_time_value(
    expression: Expression, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        expression()
    assert str(caught.value) == text
