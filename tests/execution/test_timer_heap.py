"""Alarms that ring on a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext

from goalwire.execution.monotonic import STEADY
from goalwire.execution.timer_heap import TimerEntry, TimerHeap, TimerThread
from goalwire.logging import LogRecord


def nothing() -> None:
    pass


def earliest_of(timer_heap: TimerHeap) -> int | None:
    return timer_heap.earliest


def test_alarms_ring_once_in_the_order_of_their_times() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[int] = []
    for due in (30, 10, 20):
        timer_heap.set(TimerEntry(lambda due=due: rung.append(due)), due)  # type: ignore[misc]
    timer_heap.ring_due(20)
    assert rung == [10, 20]
    assert timer_heap.earliest == 30
    timer_heap.ring_due(100)
    assert rung == [10, 20, 30]
    assert timer_heap.earliest is None


def test_setting_an_alarm_again_replaces_its_time() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[str] = []
    alarm = TimerEntry(lambda: rung.append('rung'))
    timer_heap.set(alarm, 10)
    timer_heap.set(alarm, 50)
    timer_heap.ring_due(49)
    assert rung == []
    timer_heap.ring_due(50)
    assert rung == ['rung']


def test_a_forgotten_alarm_does_not_ring() -> None:
    timer_heap = TimerHeap(nothing)
    rung: list[str] = []
    alarm = TimerEntry(lambda: rung.append('rung'))
    timer_heap.set(alarm, 10)
    timer_heap.forget(alarm)
    timer_heap.ring_due(100)
    assert rung == []


def test_only_an_earlier_time_is_told() -> None:
    told: list[None] = []
    timer_heap = TimerHeap(lambda: told.append(None))
    timer_heap.set(TimerEntry(nothing), 50)
    timer_heap.set(TimerEntry(nothing), 60)
    timer_heap.set(TimerEntry(nothing), 40)
    assert len(told) == 2


def test_an_alarm_may_set_itself_again_while_it_rings() -> None:
    timer_heap = TimerHeap(nothing)
    times: list[int] = []

    def ring() -> None:
        times.append(len(times))
        if len(times) < 3:
            timer_heap.set(alarm, 10 * (len(times) + 1))

    alarm = TimerEntry(ring)
    timer_heap.set(alarm, 10)
    timer_heap.ring_due(25)
    assert times == [0, 1]
    timer_heap.ring_due(30)
    assert times == [0, 1, 2]


def test_resetting_an_alarm_a_hundred_thousand_times_keeps_the_heap_small() -> None:
    timer_heap = TimerHeap(nothing)
    other = TimerEntry(nothing)
    timer_heap.set(other, 10**15)
    alarm = TimerEntry(nothing)
    for step in range(100_000):
        timer_heap.set(alarm, 10**12 + step)
    assert len(timer_heap.heap) < 200
    rung: list[str] = []
    alarm.ring = lambda: rung.append('alarm')
    other.ring = lambda: rung.append('other')
    timer_heap.ring_due(10**16)
    assert rung == ['alarm', 'other']


def test_an_alarm_that_moves_between_agendas_for_ever_leaves_little_behind_in_either() -> None:
    one, other = TimerHeap(nothing), TimerHeap(nothing)
    alarm = TimerEntry(nothing)
    for _ in range(5000):
        one.set(alarm, 10**15)
        other.set(alarm, 10**15)
    assert len(one.heap) + len(other.heap) < 200


def test_an_agenda_that_an_alarm_has_left_cannot_forget_it() -> None:
    one, other = TimerHeap(nothing), TimerHeap(nothing)
    rung: list[str] = []
    alarm = TimerEntry(lambda: rung.append('rung'))
    one.set(alarm, 10)
    other.set(alarm, 10)
    one.forget(alarm)
    one.ring_due(100)
    assert rung == []
    other.ring_due(100)
    assert rung == ['rung']


def test_an_interrupted_set_is_made_good_by_the_next_ring() -> None:
    rung: list[str] = []
    timer_heap = TimerHeap(lambda: None)
    timer_heap.set(TimerEntry(lambda: rung.append('late')), 50)
    timer_heap.earliest = 10  # as where a signal's handler raises between the two steps of `set`
    timer_heap.ring_due(20)
    assert (earliest_of(timer_heap), rung) == (50, [])
    timer_heap.ring_due(50)
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
def alarms(context: SmallContext) -> Iterator[TimerThread]:
    alarms = TimerThread(context.shutdown_signal, 'test-alarms')
    yield alarms
    context.shutdown()
    alarms.close()


def test_alarms_ring_in_the_order_of_their_due_times_and_not_before(alarms: TimerThread) -> None:
    rung: Collector[tuple[int, int]] = Collector()
    begun = STEADY.now()
    kept = [TimerEntry(lambda due=due: rung((due, STEADY.now()))) for due in (30, 10, 20)]  # type: ignore[misc]
    for alarm, due in zip(kept, (30, 10, 20), strict=True):
        alarms.set(alarm, begun + due * MS)
    told = rung.expect(3)
    assert [due for due, _ in told] == [10, 20, 30]
    assert all(now >= begun + due * MS for due, now in told)


def test_an_alarm_that_was_dropped_stays_silent_and_one_set_again_rings_once(alarms: TimerThread) -> None:
    rung: Collector[str] = Collector()
    dropped, moved = TimerEntry(lambda: rung('dropped')), TimerEntry(lambda: rung('moved'))
    alarms.set(dropped, STEADY.now() + 5 * MS)
    alarms.set(moved, STEADY.now() + 3600_000 * MS)
    alarms.drop(dropped)
    alarms.soon(moved)
    last = TimerEntry(lambda: rung('last'))
    alarms.set(last, STEADY.now() + 20 * MS)
    assert rung.expect(2) == ['moved', 'last']


def test_the_end_of_the_context_rings_what_is_left(context: SmallContext, alarms: TimerThread) -> None:
    rung: Collector[str] = Collector()
    alarms.set(TimerEntry(lambda: rung('for ever')), 2**62)
    alarms.set(TimerEntry(lambda: rung('an hour')), STEADY.now() + 3600_000 * MS)
    context.shutdown()
    assert sorted(rung.expect(2)) == ['an hour', 'for ever']
    alarms.close()
    alarms.close()
    alarms.set(TimerEntry(lambda: rung('late')), 2**62)
    assert 'late' in rung.items


def _fail() -> None:
    raise ValueError('a mistake')


def test_one_that_raises_spares_the_others(alarms: TimerThread, records: list[LogRecord]) -> None:
    rung: Collector[str] = Collector()
    alarms.set(TimerEntry(_fail), STEADY.now() + MS)
    alarms.set(TimerEntry(lambda: rung('next')), STEADY.now() + MS)
    assert rung.expect(1) == ['next']
    assert 'an alarm failed' in records[-1].message


def test_the_thread_starts_with_the_first_alarm(context: SmallContext) -> None:
    alarms = TimerThread(context.shutdown_signal, 'test-unused-alarms')
    alarms.close()
    assert 'test-unused-alarms' not in {thread.name for thread in threading.enumerate()}


def test_alarms_that_many_threads_set_and_drop_are_not_lost(alarms: TimerThread) -> None:
    """Who waits for an answer sets and drops; nothing of that may be lost."""
    rung: Collector[None] = Collector()

    def source() -> None:
        for _ in range(200):
            given_up = TimerEntry(lambda: rung(None))
            alarms.set(given_up, STEADY.now() + 3600_000 * MS)
            alarms.drop(given_up)
            alarms.set(TimerEntry(lambda: rung(None)), STEADY.now())

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
    alarms: TimerThread, context: SmallContext
) -> None:
    early, late = Ended(), Ended()
    alarms.tell_end(early)
    context.shutdown()
    assert early.threads.expect(1) == ['test-alarms']
    alarms.tell_end(late)
    assert late.threads.expect(1) == [threading.current_thread().name]


def test_who_is_gone_is_told_of_no_end(alarms: TimerThread, context: SmallContext) -> None:
    told: Collector[str] = Collector()
    gone, there = Ended(), Ended()
    gone.threads = there.threads = told
    alarms.tell_end(gone)
    alarms.tell_end(there)
    del gone
    context.shutdown()
    alarms.close()
    assert told.expect(1) == ['test-alarms']
