"""How long things took: buckets of powers of two, and what is read from them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.rules.latencies import Latencies


def noted(*durations: int) -> Latencies:
    latencies = Latencies()
    for ns in durations:
        latencies.add(ns)
    return latencies


def test_nothing_took_no_time() -> None:
    histogram = noted().histogram()
    assert (histogram.count, histogram.p50, histogram.p99) == (0, 0.0, 0.0)


def test_each_bucket_holds_a_power_of_two() -> None:
    counts = noted(0, 1, 2, 3, 4, 7, 8).histogram().counts
    assert counts[:5] == (1, 1, 2, 2, 1)
    assert len(counts) == 65


def test_a_clock_that_was_set_back_counts_as_no_time() -> None:
    assert noted(-1, -(2**40)).histogram().counts[0] == 2


def test_the_longest_difference_of_two_times_has_its_bucket() -> None:
    assert noted(2**64 - 1).histogram().counts[64] == 1


@given(st.lists(st.integers(1, 2**40), min_size=1), st.floats(0.01, 1.0))
def test_a_quantile_is_in_the_bucket_of_the_exact_one(durations: list[int], share: float) -> None:
    ordered = sorted(durations)
    exact = next(ns for rank, ns in enumerate(ordered, 1) if rank >= share * len(ordered))
    found = noted(*durations).histogram().quantile(share) * 1e9
    assert exact / 2 * 0.999 <= found <= exact * 2 * 1.001


def test_the_median_and_the_99th_of_a_hundred() -> None:
    histogram = noted(*[1_000_000] * 98, *[1_000_000_000] * 2).histogram()
    assert 0.0005 < histogram.p50 < 0.002
    assert 0.5 < histogram.p99 < 2


@pytest.mark.parametrize('share', [-0.1, 1.1])
def test_a_share_is_from_none_to_all(share: float) -> None:
    with pytest.raises(ValueError, match='from 0 to 1'):
        noted(1).histogram().quantile(share)
