from __future__ import annotations

from dataclasses import dataclass

import pytest

from goalwire.logging import LoggingSeverity, RcutilsLogger
from goalwire.logging.filters import Throttle, get_filters_from_kwargs, supported_filters


@dataclass
class Instant:
    nanoseconds: int


class HandClock:
    """A clock that the test moves."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def now(self) -> Instant:
        return Instant(int(self.seconds * 1e9))


def test_once_lets_only_the_first_call_of_a_line_pass() -> None:
    logger = RcutilsLogger('a')
    assert [logger.info('x', once=True) for _ in range(3)] == [True, False, False]


def test_skip_first_lets_all_but_the_first_call_pass() -> None:
    logger = RcutilsLogger('a')
    assert [logger.info('x', skip_first=True) for _ in range(3)] == [False, True, True]


def test_skip_first_and_once_let_only_the_second_call_pass() -> None:
    logger = RcutilsLogger('a')
    assert [logger.info('x', once=True, skip_first=True) for _ in range(3)] == [False, True, False]


def test_two_calls_in_one_line_have_filters_of_their_own() -> None:
    logger = RcutilsLogger('a')
    assert (logger.info('x', once=True), logger.info('x', once=True)) == (True, True)


def test_throttle_lets_one_call_pass_in_each_span_of_its_clock() -> None:
    logger, clock = RcutilsLogger('a'), HandClock()
    passed = []
    for tenth in range(6):
        clock.seconds = tenth / 10
        passed.append(logger.info('x', throttle_duration_sec=0.25, throttle_time_source_type=clock))
    assert passed == [True, False, False, True, False, False]


def test_throttle_logs_again_at_once_when_its_clock_jumped_back() -> None:
    logger, clock, passed = RcutilsLogger('a'), HandClock(), []
    for seconds in (100.0, 100.1, 3.0, 3.1):
        clock.seconds = seconds
        passed.append(logger.info('x', throttle_duration_sec=1, throttle_time_source_type=clock))
    assert passed == [True, False, True, False]


def test_throttle_uses_a_clock_of_its_own_where_none_is_given() -> None:
    logger = RcutilsLogger('a')
    assert [logger.info('x', throttle_duration_sec=3600) for _ in range(2)] == [True, False]


def test_a_negative_throttle_lets_everything_pass() -> None:
    logger = RcutilsLogger('a')
    assert [logger.info('x', throttle_duration_sec=-1) for _ in range(2)] == [True, True]


@pytest.mark.parametrize('clock', ['STEADY_TIME', HandClock])
def test_throttle_refuses_what_is_no_clock_instance(clock: object) -> None:
    with pytest.raises(
        ValueError, match=r'Received throttle_time_source_type of ".*" is not a clock instance'
    ):
        RcutilsLogger('a').info('x', throttle_duration_sec=1, throttle_time_source_type=clock)  # type: ignore[arg-type]


def test_throttle_refuses_a_duration_that_is_no_number() -> None:
    with pytest.raises(TypeError, match="throttle_duration_sec must be a number of seconds, got '1'"):
        RcutilsLogger('a').info('x', throttle_duration_sec='1')  # type: ignore[arg-type]


def test_a_clock_without_a_duration_is_refused() -> None:
    with pytest.raises(
        TypeError, match='required parameter "throttle_duration_sec" not specified but is required'
    ):
        RcutilsLogger('a').info('x', throttle_time_source_type=HandClock())


def test_an_unknown_option_is_refused_with_the_known_ones() -> None:
    known = r"\['throttle_duration_sec', 'throttle_time_source_type', 'skip_first', 'once'\]"
    with pytest.raises(
        TypeError, match=f'parameter "foo" is not one of the recognized logging options "{known}"'
    ):
        RcutilsLogger('a').info('x', foo=1)  # type: ignore[call-arg]


def test_options_that_are_off_ask_for_no_filter() -> None:
    assert get_filters_from_kwargs(once=False, skip_first=False, throttle_duration_sec=0) == []


def test_filters_are_named_in_the_order_in_which_they_are_asked() -> None:
    asked = get_filters_from_kwargs(once=True, skip_first=True, throttle_duration_sec=1)
    assert asked == list(supported_filters) == ['throttle', 'skip_first', 'once']


def test_a_filter_works_on_its_own_as_rclpy_offers_it() -> None:
    context: dict[str, object] = {}
    clock = HandClock()
    Throttle.initialize_context(context, throttle_duration_sec=1, throttle_time_source_type=clock)
    assert [Throttle.should_log(context), Throttle.should_log(context)] == [True, False]
    clock.seconds = 1
    assert Throttle.should_log(context)


def test_a_severity_is_given_by_the_method_alone() -> None:
    with pytest.raises(TypeError, match="got multiple values for argument 'severity'"):
        get_filters_from_kwargs(severity=LoggingSeverity.DEBUG)
