"""Times that ROS messages have room for."""

from __future__ import annotations

import pytest

from humanoid.clock import duration_msg, seconds, time_msg

LAST = (2**31 - 1, 999_999_999)


@pytest.mark.parametrize('length', [0.0, -0.0, 5e-324, 1e-9, 0.25, 1.5, 86400.0])
def test_a_duration_keeps_its_nanoseconds(length: float) -> None:
    assert seconds(duration_msg(length)) == pytest.approx(length, abs=1e-9)


@pytest.mark.parametrize('length', [2.0**31, 3e9, 1e308])
def test_a_duration_beyond_the_messages_is_the_longest_of_these(length: float) -> None:
    message = duration_msg(length)
    assert (message.sec, message.nanosec) == LAST


def test_a_moment_after_2038_is_the_last_that_messages_can_name() -> None:
    message = time_msg(2_200_000_000 * 10**9)
    assert (message.sec, message.nanosec) == LAST
    assert time_msg(1_500_000_000_000_000_001).nanosec == 1
