"""Percentiles and histograms of calls."""

from __future__ import annotations

import pytest

from goalwire.observe.latencies import Latencies, show_seconds


def test_percentiles_are_those_of_the_nearest_rank() -> None:
    latencies = Latencies()
    assert (latencies.percentile(0.5), latencies.histogram()) == (0.0, [])
    for number in range(1, 101):
        latencies.note(number / 1000)
    assert [latencies.percentile(share) for share in (0.0, 0.5, 0.95, 0.99, 1.0)] == [
        0.001,
        0.05,
        0.095,
        0.099,
        0.1,
    ]


def test_every_percent_of_a_hundred_calls_is_a_call() -> None:
    """0.07 * 100 is more than 7 in floating point."""
    latencies = Latencies()
    for number in range(1, 101):
        latencies.note(float(number))
    assert [latencies.percentile(share / 100) for share in range(1, 101)] == list(range(1, 101))


def test_only_the_latest_calls_are_kept_and_all_are_counted() -> None:
    latencies = Latencies(kept=3)
    for seconds in (9.0, 1.0, 2.0, 3.0):
        latencies.note(seconds)
    assert (len(latencies), latencies.number, latencies.percentile(1.0)) == (3, 4, 3.0)


def test_a_histogram_has_a_bin_for_each_call_and_no_empty_ends() -> None:
    latencies = Latencies()
    for seconds in (0.0015, 0.0016, 0.004, 0.02):
        latencies.note(seconds)
    limits, numbers = zip(*latencies.histogram(), strict=True)
    assert limits == pytest.approx((0.002, 0.003, 0.005, 0.007, 0.01, 0.02, 0.03))
    assert numbers == (2, 0, 1, 0, 0, 0, 1)


def test_times_are_shown_in_the_unit_that_suits() -> None:
    assert [show_seconds(each) for each in (0.0015, 0.25, 1.5)] == ['1.5 ms', '250 ms', '1.5 s']
