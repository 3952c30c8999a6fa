"""Alarms that ring on a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext

from goalwire.execution.monotonic import STEADY
from goalwire.execution.timer_heap import TimerEntry, TimerThread
from goalwire.logging import LogRecord

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
