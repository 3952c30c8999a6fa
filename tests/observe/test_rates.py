"""How often messages come, as every screen tells it."""

from __future__ import annotations

import pytest

from goalwire.observe.rates import Rate


def hertz_at(rate: Rate, now: float) -> float | None:
    pace = rate.pace(now)
    return None if pace is None else pace.messages


@pytest.mark.parametrize('hertz', [0.2, 1.0, 10.0, 400.0])
@pytest.mark.parametrize('phase', [0.0, 0.3, 0.999])
def test_a_rate_is_right_whenever_it_is_told(hertz: float, phase: float) -> None:
    """It is read each second, beginning before the first message, which comes at any time."""
    rate = Rate()
    first = 3.0 + phase
    told: list[float | None] = []
    for second in range(60):
        if second >= first:
            count = int((second - first) * hertz) + 1
            rate.note(count, first + (count - 1) / hertz)
        told.append(hertz_at(rate, second))
    known = [each for each in told if each is not None]
    assert known == pytest.approx([hertz] * len(known))
    assert len(known) >= 60 - first - 2 - 2 / hertz, 'it is told from the second reading on'


def test_a_rate_follows_the_last_seconds_and_stops_with_the_messages() -> None:
    rate = Rate()
    for second in range(10):
        rate.note(20 * second, second)
    for second in range(10, 20):
        rate.note(180 + 5 * (second - 9), second)
    assert hertz_at(rate, 19) == pytest.approx(5.0)
    assert hertz_at(rate, 22) == pytest.approx(5.0), 'the next may come yet'
    assert hertz_at(rate, 22.1) == 0.0
    assert hertz_at(rate, 30) == 0.0
    rate.note(231, 31.0)
    assert hertz_at(rate, 31) is None
    rate.note(241, 32.0)
    assert hertz_at(rate, 32) == pytest.approx(10.0)


def test_of_one_message_or_of_a_burst_no_rate_is_told() -> None:
    rate = Rate()
    assert hertz_at(rate, 0.0) is None
    rate.note(1, 1.0)
    assert hertz_at(rate, 100.0) is None
    burst = Rate()
    burst.note(1, 0.99)
    burst.note(5, 1.01)
    assert hertz_at(burst, 1.01) is None


def test_bytes_are_those_of_the_same_seconds() -> None:
    rate = Rate()
    for number in range(1, 102):
        rate.note(number, 10 + number / 100, number * 10)
    assert rate.pace(11.1) == pytest.approx((100.0, 1000.0))
    assert rate.pace(20) == (0.0, 0.0)


def test_the_pace_of_a_moment_is_known_however_short_it_was() -> None:
    rate = Rate()
    assert rate.latest() is None
    rate.note(1, 1.0, 100)
    rate.note(3, 1.1, 300)
    assert rate.pace(1.2) is None
    assert rate.latest() == pytest.approx((20.0, 2000.0))
