"""Goals of every client, as their servers report them."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from unique_identifier_msgs.msg import UUID

from goalwire.idl.registry import register_definitions
from goalwire.observe.goals import KEPT, GoalTable, ReportedGoal, lanes, read_reported_goals, status_name
from goalwire.observe.messages import interface_class

register_definitions(
    'observed_goals',
    {
        'msg/Remaining': 'float64 distance_remaining\n',
        'msg/Percent': 'float64 x\nfloat64 percent\n',
        'msg/Fraction': 'float64 fraction_done\n',
    },
)


def feedback(name: str, **fields: float) -> Any:
    return interface_class(f'observed_goals/msg/{name}')(**fields)


def remaining(distance: float) -> Any:
    return feedback('Remaining', distance_remaining=distance)


def reported(goal_id: str, status: str, accepted: float) -> ReportedGoal:
    return ReportedGoal(goal_id, status, accepted)


def test_a_status_array_is_read() -> None:
    info = GoalInfo(goal_id=UUID(uuid=[7] * 16))
    info.stamp.sec, info.stamp.nanosec = 5, 500_000_000
    array = GoalStatusArray(status_list=[GoalStatus(goal_info=info, status=2), GoalStatus(status=99)])
    first, second = read_reported_goals(array)
    assert first == ('07' * 16, 'EXECUTING', 5.5)
    assert (first.is_active, second.status, second.is_active) == (True, 'UNKNOWN', False)
    assert [status_name(number) for number in (-1, 0, 6, 7)] == ['UNKNOWN', 'UNKNOWN', 'ABORTED', 'UNKNOWN']


def test_goals_of_everybody_are_followed_to_their_end() -> None:
    table = GoalTable()
    mine = table.note_sent('/go', 'aa', {'x': 1.0}, 10.0)
    goals = [reported('aa', 'EXECUTING', 9.9), reported('bb', 'ACCEPTED', 9.8)]
    assert [goal.goal_id for goal in table.take_statuses('/go', goals, 11.0)] == ['aa', 'bb']
    table.take_feedback('/go', 'aa', remaining(4.0), 12.0)
    table.take_feedback('/go', 'aa', remaining(1.0), 13.0)
    other = table.get('/go', 'bb')
    assert other is not None
    assert (mine.is_mine, other.is_mine, mine.progress, list(mine.ticks)) == (True, False, 0.75, [12.0, 13.0])
    table.take_statuses('/go', [reported('aa', 'SUCCEEDED', 9.9), reported('bb', 'ABORTED', 9.8)], 14.0)
    assert (mine.status, mine.ended, mine.progress, other.status) == ('SUCCEEDED', 14.0, 1.0, 'ABORTED')
    assert table.take_statuses('/go', [reported('aa', 'EXECUTING', 9.9)], 15.0) == [], 'it has ended'
    assert table.active() == []


def test_an_answer_that_comes_behind_the_status_changes_nothing() -> None:
    table = GoalTable()
    goal = table.note_sent('/go', 'aa', {}, 1.0)
    table.take_statuses('/go', [reported('aa', 'EXECUTING', 1.0)], 1.1)
    assert not goal.move('ACCEPTED', 1.2)
    assert goal.status == 'EXECUTING'


def test_a_goal_that_had_ended_before_it_was_seen_is_a_moment_of_the_past() -> None:
    table = GoalTable()
    table.take_statuses('/go', [reported('aa', 'SUCCEEDED', 100.0)], 500.0)
    goal = table.get('/go', 'aa')
    assert goal is not None
    assert (goal.began, goal.ended) == (100.0, 100.0)


def test_a_servers_stamp_becomes_a_reading_of_the_monotonic_clock() -> None:
    table = GoalTable()
    goals = [reported('aa', 'EXECUTING', 1_000_100.0), reported('bb', 'EXECUTING', 1_000_900.0)]
    table.take_statuses('/go', goals, 500.0, 1_000_000.0)
    began = [goal.began for goal in table]
    assert began == [100.0, 500.0], 'one that a clock ahead of ours stamped began now'
    assert [goal.accepted for goal in table] == [1_000_100.0, 1_000_900.0]


def test_old_goals_go_and_active_ones_stay() -> None:
    table = GoalTable()
    table.take_statuses('/a', [reported('first', 'EXECUTING', 0.0)], 0.0)
    for number in range(KEPT + 50):
        table.take_statuses('/a', [reported(f'{number}', 'SUCCEEDED', 1.0)], 1.0)
    assert len(table) == KEPT
    assert table.get('/a', 'first') is not None


def test_goals_that_overlap_have_lanes_of_their_own() -> None:
    table = GoalTable()
    for goal_id, began, ended in (('a', 0.0, 5.0), ('b', 1.0, 3.0), ('c', 4.0, 6.0), ('d', 5.5, None)):
        goal = table.note_sent('/a', goal_id, {}, began)
        if ended is not None:
            table.end(goal, 'ABORTED', '', ended)
    assert [(goal.goal_id, row) for goal, row in lanes(table, 7.0)] == [
        ('a', 0),
        ('b', 1),
        ('c', 1),
        ('d', 0),
    ]
    assert [row for _, row in lanes(table, 7.0, margin=2.0)] == [0, 1, 2, 1]


@pytest.mark.parametrize(
    ('name', 'fields', 'field', 'done'),
    [
        ('Fraction', {'fraction_done': 0.4}, None, 0.4),
        ('Percent', {'percent': 40.0}, None, 0.4),
        ('Percent', {'percent': 40.0, 'x': 3.0}, 'x/6', 0.5),
        ('Percent', {'percent': 40.0}, 'of_another_action', 0.4),
        ('Remaining', {'distance_remaining': 2.0}, None, 0.0),
    ],
)
def test_progress_is_read_from_the_field_that_is_named_or_likely(
    name: str, fields: dict[str, float], field: str | None, done: float
) -> None:
    goal = GoalTable(field).take_feedback('/a', 'x', feedback(name, **fields), 0.0)
    assert goal.progress == pytest.approx(done)


def test_of_a_goal_that_ran_before_nobody_guesses_what_remains() -> None:
    table = GoalTable()
    table.watch('/go', 10.0)
    table.take_feedback('/go', 'old', remaining(8.0), 10.5)
    table.take_statuses('/go', [reported('old', 'EXECUTING', 5.0), reported('new', 'EXECUTING', 11.0)], 11.0)
    for goal_id in ('old', 'new'):
        for distance in (4.0, 1.0):
            table.take_feedback('/go', goal_id, remaining(distance), 12.0)
    old, new = table.list_reported('/go', 9)
    assert (old.progress, new.progress) == (None, 0.75)
    table.take_feedback('/go', 'old', feedback('Fraction', fraction_done=0.5), 13.0)
    assert old.progress == 0.5, 'such a field tells it at any time'


def test_a_servers_goals_are_the_active_ones_and_then_the_latest_that_ended() -> None:
    table = GoalTable()
    statuses = {'a': 'SUCCEEDED', 'b': 'EXECUTING', 'c': 'ABORTED', 'd': 'CANCELED'}
    table.take_statuses('/go', [reported(goal_id, each, 1.0) for goal_id, each in statuses.items()], 2.0)
    table.take_feedback('/go', 'e', remaining(1.0), 3.0)  # no status has told of it yet
    assert [goal.goal_id for goal in table.list_reported('/go', 2)] == ['b', 'c', 'd']
    table.take_statuses('/go', [reported('b', 'SUCCEEDED', 1.0)], 4.0)
    assert [goal.goal_id for goal in table.list_reported('/go', 2)] == ['b'], 'the server forgot the others'
    assert table.get('/go', 'a') is not None
    table.forget('/go')
    assert (list(table), table.list_reported('/go', 2)) == ([], [])
