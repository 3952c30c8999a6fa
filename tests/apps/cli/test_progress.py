"""How far a goal is, as the fields of its feedback tell."""

from __future__ import annotations

import pytest
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import Point
from sensor_msgs.msg import BatteryState

from goalwire.apps.cli.commands.action.goals import GoalLine, ran_before
from goalwire.apps.cli.commands.action.progress import Progress, bar, likely_field


@pytest.mark.parametrize(
    ('number', 'done'), [(0.5, 0.5), (-1.0, 0.0), (7.0, 1.0), (float('inf'), 1.0), (float('nan'), 0.0)]
)
def test_whatever_a_peer_sends_is_drawn(number: float, done: float) -> None:
    assert Progress('x').of(Point(x=number)) == done
    assert len(bar(done).split()[0]) == 30


def test_what_remains_begins_at_nothing_done() -> None:
    class Feedback(Point):
        distance_remaining = 0.0

    progress = Progress('distance_remaining')
    feedback = Feedback()
    shown = []
    for feedback.distance_remaining in (8.0, 2.0, float('nan'), 0.0):
        shown.append(progress.of(feedback))
    assert shown == [0.0, 0.75, 0.0, 1.0]


def test_who_has_missed_the_first_feedback_does_not_guess_what_remains() -> None:
    class Feedback(Point):
        distance_remaining = 2.0

    assert Progress('distance_remaining', saw_start=False).of(Feedback()) is None
    assert Progress('x', saw_start=False).of(Point(x=0.5)) == 0.5
    goals = [GoalLine('old', 'EXECUTING', 5.0), GoalLine('new', 'EXECUTING', 15.0)]
    assert ran_before(goals, began=10.0) == {'old'}


def test_the_name_of_a_field_tells_that_it_is_progress() -> None:
    assert likely_field(BatteryState()) == 'percentage/100'
    assert likely_field(Fibonacci.Feedback()) is None
    assert likely_field(Point()) is None
