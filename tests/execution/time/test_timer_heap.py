"""Entries that ring on a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext

from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.time.timer_heap import TimerEntry, TimerHeap, TimerThread
from goalwire.logging import LogRecord


def nothing() -> None:
    pass


def earliest_of(timer_heap: TimerHeap) -> int | None:
    return timer_heap.earliest


def test_entries_are_called_once_in_the_order_of_their_times() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[int] = []
    for due in (30, 10, 20):
        timer_heap.set(TimerEntry(lambda due=due: rung.append(due)), due)  # type: ignore[misc]
    timer_heap.call_due(20)
    assert rung == [10, 20]
    assert timer_heap.earliest == 30
    timer_heap.call_due(100)
    assert rung == [10, 20, 30]
    assert timer_heap.earliest is None


def test_setting_an_entry_again_replaces_its_time() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[str] = []
    entry = TimerEntry(lambda: rung.append('rung'))
    timer_heap.set(entry, 10)
    timer_heap.set(entry, 50)
    timer_heap.call_due(49)
    assert rung == []
    timer_heap.call_due(50)
    assert rung == ['rung']


def test_a_discarded_entry_is_not_called() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[str] = []
    entry = TimerEntry(lambda: rung.append('rung'))
    timer_heap.set(entry, 10)
    timer_heap.discard(entry)
    timer_heap.call_due(100)
    assert rung == []


def test_only_an_earlier_time_is_told() -> None:
    told: list[None] = []
    timer_heap = TimerHeap(lambda: told.append(None))
    timer_heap.set(TimerEntry(nothing), 50)
    timer_heap.set(TimerEntry(nothing), 60)
    timer_heap.set(TimerEntry(nothing), 40)
    assert len(told) == 2


def test_an_entry_may_set_itself_again_while_it_is_called() -> None:
    timer_heap = TimerHeap(nothing)
    times: list[int] = []

    def ring() -> None:
        times.append(len(times))
        if len(times) < 3:
            timer_heap.set(entry, 10 * (len(times) + 1))

    entry = TimerEntry(ring)
    timer_heap.set(entry, 10)
    timer_heap.call_due(25)
    assert times == [0, 1]
    timer_heap.call_due(30)
    assert times == [0, 1, 2]


def test_resetting_an_entry_a_hundred_thousand_times_keeps_the_heap_small() -> None:
    timer_heap = TimerHeap(nothing)
    other = TimerEntry(nothing)
    timer_heap.set(other, 10**15)
    entry = TimerEntry(nothing)
    for step in range(100_000):
        timer_heap.set(entry, 10**12 + step)
    assert len(timer_heap.heap) < 200
    rung: list[str] = []
    entry.call = lambda: rung.append('entry')
    other.call = lambda: rung.append('other')
    timer_heap.call_due(10**16)
    assert rung == ['entry', 'other']


def test_an_entry_that_moves_between_heaps_for_ever_leaves_little_behind_in_either() -> None:
    one, other = TimerHeap(nothing), TimerHeap(nothing)
    entry = TimerEntry(nothing)
    for _ in range(5000):
        one.set(entry, 10**15)
        other.set(entry, 10**15)
    assert len(one.heap) + len(other.heap) < 200


def test_a_heap_that_an_entry_has_left_cannot_discard_it() -> None:
    one, other = TimerHeap(nothing), TimerHeap(nothing)
    rung: list[str] = []
    entry = TimerEntry(lambda: rung.append('rung'))
    one.set(entry, 10)
    other.set(entry, 10)
    one.discard(entry)
    one.call_due(100)
    assert rung == []
    other.call_due(100)
    assert rung == ['rung']


def test_an_interrupted_set_is_made_good_by_the_next_ring() -> None:
    rung: list[str] = []
    timer_heap = TimerHeap(lambda: None)
    timer_heap.set(TimerEntry(lambda: rung.append('late')), 50)
    timer_heap.earliest = 10  # as where a signal's handler raises between the two steps of `set`
    timer_heap.call_due(20)
    assert (earliest_of(timer_heap), rung) == (50, [])
    timer_heap.call_due(50)
    assert (earliest_of(timer_heap), rung) == (None, ['late'])


def test_where_nobody_sleeps_an_earlier_time_is_told_to_nobody() -> None:
    told: list[str] = []
    sleepers: list[str] = []
    timer_heap = TimerHeap(lambda: told.append('earlier'), sleepers)
    timer_heap.set(TimerEntry(nothing), 50)
    sleepers.append('somebody')
    timer_heap.set(TimerEntry(nothing), 40)
    assert told == ['earlier']


MS = 1_000_000


@pytest.fixture
def context() -> Iterator[SmallContext]:
    context = SmallContext()
    yield context
    context.shutdown()


@pytest.fixture
def entries(context: SmallContext) -> Iterator[TimerThread]:
    entries = TimerThread(context.shutdown_signal, 'test-entries')
    yield entries
    context.shutdown()
    entries.close()


def test_entries_are_called_in_the_order_of_their_due_times_and_not_before(entries: TimerThread) -> None:
    rung: Collector[tuple[int, int]] = Collector()
    begun = STEADY.now()
    kept = [TimerEntry(lambda due=due: rung((due, STEADY.now()))) for due in (30, 10, 20)]  # type: ignore[misc]
    for entry, due in zip(kept, (30, 10, 20), strict=True):
        entries.set(entry, begun + due * MS)
    told = rung.expect(3)
    assert [due for due, _ in told] == [10, 20, 30]
    assert all(now >= begun + due * MS for due, now in told)


def test_an_entry_that_was_discarded_is_not_called_and_one_set_again_is_called_once(
    entries: TimerThread,
) -> None:
    rung: Collector[str] = Collector()
    dropped, moved = TimerEntry(lambda: rung('dropped')), TimerEntry(lambda: rung('moved'))
    entries.set(dropped, STEADY.now() + 5 * MS)
    entries.set(moved, STEADY.now() + 3600_000 * MS)
    entries.discard(dropped)
    entries.soon(moved)
    last = TimerEntry(lambda: rung('last'))
    entries.set(last, STEADY.now() + 20 * MS)
    assert rung.expect(2) == ['moved', 'last']


def test_the_end_of_the_context_rings_what_is_left(context: SmallContext, entries: TimerThread) -> None:
    rung: Collector[str] = Collector()
    entries.set(TimerEntry(lambda: rung('for ever')), 2**62)
    entries.set(TimerEntry(lambda: rung('an hour')), STEADY.now() + 3600_000 * MS)
    context.shutdown()
    assert sorted(rung.expect(2)) == ['an hour', 'for ever']
    entries.close()
    entries.close()
    entries.set(TimerEntry(lambda: rung('late')), 2**62)
    assert 'late' in rung.items


def _fail() -> None:
    raise ValueError('a mistake')


def test_one_that_raises_spares_the_others(entries: TimerThread, records: list[LogRecord]) -> None:
    rung: Collector[str] = Collector()
    entries.set(TimerEntry(_fail), STEADY.now() + MS)
    entries.set(TimerEntry(lambda: rung('next')), STEADY.now() + MS)
    assert rung.expect(1) == ['next']
    assert 'a timer failed' in records[-1].message


def test_the_thread_starts_with_the_first_entry(context: SmallContext) -> None:
    entries = TimerThread(context.shutdown_signal, 'test-unused-entries')
    entries.close()
    assert 'test-unused-entries' not in {thread.name for thread in threading.enumerate()}


def test_entries_that_many_threads_set_and_discard_are_not_lost(entries: TimerThread) -> None:
    """Threads that wait for an answer set and discard entries; no such step may be lost."""
    rung: Collector[None] = Collector()

    def source() -> None:
        for _ in range(200):
            given_up = TimerEntry(lambda: rung(None))
            entries.set(given_up, STEADY.now() + 3600_000 * MS)
            entries.discard(given_up)
            entries.set(TimerEntry(lambda: rung(None)), STEADY.now())

    threads = [threading.Thread(target=source) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    rung.expect(800)
    assert len(rung.items) == 800


class Ended:
    """Wants to know of the end."""

    def __init__(self) -> None:
        self.threads: Collector[str] = Collector()

    def end(self) -> None:
        self.threads(threading.current_thread().name)


def test_the_end_of_the_lifeline_is_told_on_the_thread_and_later_at_once(
    entries: TimerThread, context: SmallContext
) -> None:
    early, late = Ended(), Ended()
    entries.tell_end(early)
    context.shutdown()
    assert early.threads.expect(1) == ['test-entries']
    entries.tell_end(late)
    assert late.threads.expect(1) == [threading.current_thread().name]


def test_who_is_gone_is_told_of_no_end(entries: TimerThread, context: SmallContext) -> None:
    told: Collector[str] = Collector()
    gone, there = Ended(), Ended()
    gone.threads = there.threads = told
    entries.tell_end(gone)
    entries.tell_end(there)
    del gone
    context.shutdown()
    entries.close()
    assert told.expect(1) == ['test-entries']
