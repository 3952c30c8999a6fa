from __future__ import annotations

import gc
import threading
from weakref import ref

import pytest

from goalwire.execution.lifeline import Lifeline
from goalwire.execution.waiting import Keeper


def test_it_ends_once_and_tells_everybody_once() -> None:
    lifeline = Lifeline()
    told: list[str] = []
    lifeline.watch(lambda: told.append('a'))
    lifeline.watch(lambda: told.append('b'))
    assert (lifeline.alive, lifeline.reason) == (True, None)
    assert lifeline.end('shutdown')
    assert not lifeline.end('again')
    assert (lifeline.alive, lifeline.reason) == (False, 'shutdown')
    assert sorted(told) == ['a', 'b']


def test_who_watches_too_late_is_told_at_once() -> None:
    lifeline = Lifeline()
    lifeline.end('over')
    told: list[str] = []
    lifeline.watch(lambda: told.append('a'))
    assert told == ['a']


def test_a_closed_watch_is_not_told() -> None:
    lifeline = Lifeline()
    told: list[str] = []
    watch = lifeline.watch(lambda: told.append('a'))
    watch.close()
    watch.close()
    lifeline.end('over')
    assert told == []


def test_nobody_is_missed_who_begins_to_watch_while_it_ends() -> None:
    for _ in range(500):
        lifeline = Lifeline()
        told = threading.Semaphore(0)
        both = threading.Barrier(2)

        def end(lifeline: Lifeline = lifeline, both: threading.Barrier = both) -> None:
            both.wait()
            lifeline.end('over')

        thread = threading.Thread(target=end)
        thread.start()
        both.wait()
        lifeline.watch(told.release)
        thread.join()
        assert told.acquire(timeout=10)
        assert not told.acquire(blocking=False)


def test_the_end_wakes_every_waiter_for_all_of_its_life() -> None:
    lifeline = Lifeline()
    waiters = [lifeline.new_waiter() for _ in range(2)]
    for waiter in waiters:
        waiter.wake()
        assert waiter.wait(0)
    lifeline.end('over')
    assert all(waiter.wait(0) for waiter in waiters)


def test_a_waiter_is_not_kept_by_the_lifeline_that_wakes_it() -> None:
    lifeline = Lifeline()
    forgotten = ref(lifeline.new_waiter())
    assert forgotten() is None
    lifeline.end('over')


@pytest.mark.parametrize('allocations', range(1, 12))
def test_garbage_that_is_collected_while_it_ends_keeps_nobody_asleep(allocations: int) -> None:
    lifeline = Lifeline()
    gc.collect()
    before = gc.get_threshold()
    gc.disable()
    try:
        for _ in range(40):
            garbage = Keeper(lifeline)
            garbage.interrupt = garbage.wake  # a circle
        del garbage
        waiter = lifeline.new_waiter()
        gc.set_threshold(gc.get_count()[0] + allocations)
        gc.enable()
        assert lifeline.end('over')
    finally:
        gc.set_threshold(*before)
        gc.enable()
    assert waiter.wait(0)
