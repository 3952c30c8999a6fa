from __future__ import annotations

import gc
import threading
from weakref import ref

import pytest

from goalwire.execution.waiting import ShutdownSignal, WireWaiter


def test_it_ends_once_and_tells_everybody_once() -> None:
    shutdown_signal = ShutdownSignal()
    told: list[str] = []
    shutdown_signal.watch(lambda: told.append('a'))
    shutdown_signal.watch(lambda: told.append('b'))
    assert (shutdown_signal.alive, shutdown_signal.reason) == (True, None)
    assert shutdown_signal.end('shutdown')
    assert not shutdown_signal.end('again')
    assert (shutdown_signal.alive, shutdown_signal.reason) == (False, 'shutdown')
    assert sorted(told) == ['a', 'b']


def test_who_watches_too_late_is_told_at_once() -> None:
    shutdown_signal = ShutdownSignal()
    shutdown_signal.end('over')
    told: list[str] = []
    shutdown_signal.watch(lambda: told.append('a'))
    assert told == ['a']


def test_a_closed_watch_is_not_told() -> None:
    shutdown_signal = ShutdownSignal()
    told: list[str] = []
    watch = shutdown_signal.watch(lambda: told.append('a'))
    watch.close()
    watch.close()
    shutdown_signal.end('over')
    assert told == []


def test_nobody_is_missed_who_begins_to_watch_while_it_ends() -> None:
    for _ in range(500):
        shutdown_signal = ShutdownSignal()
        told = threading.Semaphore(0)
        both = threading.Barrier(2)

        def end(shutdown_signal: ShutdownSignal = shutdown_signal, both: threading.Barrier = both) -> None:
            both.wait()
            shutdown_signal.end('over')

        thread = threading.Thread(target=end)
        thread.start()
        both.wait()
        shutdown_signal.watch(told.release)
        thread.join()
        assert told.acquire(timeout=10)
        assert not told.acquire(blocking=False)


def test_the_end_wakes_every_waiter_for_all_of_its_life() -> None:
    shutdown_signal = ShutdownSignal()
    waiters = [shutdown_signal.new_waiter() for _ in range(2)]
    for waiter in waiters:
        waiter.wake()
        assert waiter.wait(0)
    shutdown_signal.end('over')
    assert all(waiter.wait(0) for waiter in waiters)


def test_a_waiter_is_not_kept_by_the_lifeline_that_wakes_it() -> None:
    shutdown_signal = ShutdownSignal()
    forgotten = ref(shutdown_signal.new_waiter())
    assert forgotten() is None
    shutdown_signal.end('over')


@pytest.mark.parametrize('allocations', range(1, 12))
def test_garbage_that_is_collected_while_it_ends_keeps_nobody_asleep(allocations: int) -> None:
    shutdown_signal = ShutdownSignal()
    gc.collect()
    before = gc.get_threshold()
    gc.disable()
    try:
        for _ in range(40):
            garbage = WireWaiter(shutdown_signal)
            garbage.interrupt = garbage.wake  # a circle
        del garbage
        waiter = shutdown_signal.new_waiter()
        gc.set_threshold(gc.get_count()[0] + allocations)
        gc.enable()
        assert shutdown_signal.end('over')
    finally:
        gc.set_threshold(*before)
        gc.enable()
    assert waiter.wait(0)
