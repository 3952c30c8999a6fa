from __future__ import annotations

from goalwire.execution.timer_heap import TimerEntry, TimerHeap


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
