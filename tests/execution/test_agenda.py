from __future__ import annotations

from goalwire.execution.agenda import Agenda, Alarm


def nothing() -> None:
    pass


def earliest_of(agenda: Agenda) -> int | None:
    return agenda.earliest


def test_alarms_ring_once_in_the_order_of_their_times() -> None:
    agenda = Agenda(nothing)
    rung: list[int] = []
    for due in (30, 10, 20):
        agenda.set(Alarm(lambda due=due: rung.append(due)), due)  # type: ignore[misc]
    agenda.ring_due(20)
    assert rung == [10, 20]
    assert agenda.earliest == 30
    agenda.ring_due(100)
    assert rung == [10, 20, 30]
    assert agenda.earliest is None


def test_setting_an_alarm_again_replaces_its_time() -> None:
    agenda = Agenda(nothing)
    rung: list[str] = []
    alarm = Alarm(lambda: rung.append('rung'))
    agenda.set(alarm, 10)
    agenda.set(alarm, 50)
    agenda.ring_due(49)
    assert rung == []
    agenda.ring_due(50)
    assert rung == ['rung']


def test_a_forgotten_alarm_does_not_ring() -> None:
    agenda = Agenda(nothing)
    rung: list[str] = []
    alarm = Alarm(lambda: rung.append('rung'))
    agenda.set(alarm, 10)
    agenda.forget(alarm)
    agenda.ring_due(100)
    assert rung == []


def test_only_an_earlier_time_is_told() -> None:
    told: list[None] = []
    agenda = Agenda(lambda: told.append(None))
    agenda.set(Alarm(nothing), 50)
    agenda.set(Alarm(nothing), 60)
    agenda.set(Alarm(nothing), 40)
    assert len(told) == 2


def test_an_alarm_may_set_itself_again_while_it_rings() -> None:
    agenda = Agenda(nothing)
    times: list[int] = []

    def ring() -> None:
        times.append(len(times))
        if len(times) < 3:
            agenda.set(alarm, 10 * (len(times) + 1))

    alarm = Alarm(ring)
    agenda.set(alarm, 10)
    agenda.ring_due(25)
    assert times == [0, 1]
    agenda.ring_due(30)
    assert times == [0, 1, 2]


def test_resetting_an_alarm_a_hundred_thousand_times_keeps_the_heap_small() -> None:
    agenda = Agenda(nothing)
    other = Alarm(nothing)
    agenda.set(other, 10**15)
    alarm = Alarm(nothing)
    for step in range(100_000):
        agenda.set(alarm, 10**12 + step)
    assert len(agenda.heap) < 200
    rung: list[str] = []
    alarm.ring = lambda: rung.append('alarm')
    other.ring = lambda: rung.append('other')
    agenda.ring_due(10**16)
    assert rung == ['alarm', 'other']


def test_an_alarm_that_moves_between_agendas_for_ever_leaves_little_behind_in_either() -> None:
    one, other = Agenda(nothing), Agenda(nothing)
    alarm = Alarm(nothing)
    for _ in range(5000):
        one.set(alarm, 10**15)
        other.set(alarm, 10**15)
    assert len(one.heap) + len(other.heap) < 200


def test_an_agenda_that_an_alarm_has_left_cannot_forget_it() -> None:
    one, other = Agenda(nothing), Agenda(nothing)
    rung: list[str] = []
    alarm = Alarm(lambda: rung.append('rung'))
    one.set(alarm, 10)
    other.set(alarm, 10)
    one.forget(alarm)
    one.ring_due(100)
    assert rung == []
    other.ring_due(100)
    assert rung == ['rung']


def test_an_interrupted_set_is_made_good_by_the_next_ring() -> None:
    rung: list[str] = []
    agenda = Agenda(lambda: None)
    agenda.set(Alarm(lambda: rung.append('late')), 50)
    agenda.earliest = 10  # as where a signal's handler raises between the two steps of `set`
    agenda.ring_due(20)
    assert (earliest_of(agenda), rung) == (50, [])
    agenda.ring_due(50)
    assert (earliest_of(agenda), rung) == (None, ['late'])


def test_where_nobody_sleeps_an_earlier_time_is_told_to_nobody() -> None:
    told: list[str] = []
    sleepers: list[str] = []
    agenda = Agenda(lambda: told.append('earlier'), sleepers)
    agenda.set(Alarm(nothing), 50)
    sleepers.append('somebody')
    agenda.set(Alarm(nothing), 40)
    assert told == ['earlier']
