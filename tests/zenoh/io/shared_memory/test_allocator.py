"""Places in a segment: none is given twice, and all come back as one."""

from __future__ import annotations

from random import Random

from goalwire.zenoh.io.shared_memory.allocator import ALIGNMENT, Allocator, round_up


def test_the_lowest_place_that_fits_is_taken() -> None:
    places = Allocator(1 << 20)
    first, second = places.take(1000), places.take(1000)
    assert (first, second) == (0, round_up(1000))
    places.give(0, 1000)
    assert places.take(2000) == 2 * round_up(1000)
    assert places.take(900) == 0


def test_what_does_not_fit_is_refused() -> None:
    places = Allocator(4096)
    assert places.take(4097) is None
    assert places.take(4096) == 0
    assert places.take(1) is None


def test_no_place_is_given_twice_and_all_come_back_as_one() -> None:
    random, places, size = Random(7), Allocator(1 << 20), 1 << 20
    taken: dict[int, int] = {}
    for _ in range(5000):
        if taken and random.random() < 0.5:
            start = random.choice(list(taken))
            places.give(start, taken.pop(start))
            continue
        wanted = random.choice((1, 64, 65, 5000, 70_000))
        found = places.take(wanted)
        if found is not None:
            assert found % ALIGNMENT == 0
            assert found + wanted <= size
            assert all(found + wanted <= start or start + length <= found for start, length in taken.items())
            taken[found] = wanted
    for start, length in taken.items():
        places.give(start, length)
    assert places.take(size) == 0
