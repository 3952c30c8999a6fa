"""How far a goal is, as the fields of its feedback tell."""

from __future__ import annotations

import pytest
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import Point
from sensor_msgs.msg import BatteryState

from goalwire.apps.cli.commands.action.display import bar
from goalwire.observe.progress import Progress, ProgressError, likely_field


@pytest.mark.parametrize(
    ('number', 'done'), [(0.5, 0.5), (-1.0, 0.0), (7.0, 1.0), (float('inf'), 1.0), (float('nan'), 0.0)]
)
def test_whatever_a_peer_sends_is_drawn(number: float, done: float) -> None:
    assert Progress('x').read(Point(x=number)) == done
    assert len(bar(done).split()[0]) == 30


def test_what_remains_begins_at_nothing_done() -> None:
    class Feedback(Point):
        distance_remaining = 0.0

    progress = Progress('distance_remaining')
    feedback = Feedback()
    shown = []
    for feedback.distance_remaining in (8.0, 2.0, float('nan'), 0.0):
        shown.append(progress.read(feedback))
    assert shown == [0.0, 0.75, 0.0, 1.0]


def test_who_has_missed_the_first_feedback_does_not_guess_what_remains() -> None:
    class Feedback(Point):
        distance_remaining = 2.0

    assert Progress('distance_remaining', saw_start=False).read(Feedback()) is None
    assert Progress('x', saw_start=False).read(Point(x=0.5)) == 0.5


def test_the_name_of_a_field_tells_that_it_is_progress() -> None:
    assert likely_field(BatteryState()) == 'percentage/100'
    assert likely_field(Fibonacci.Feedback()) is None
    assert likely_field(Point()) is None


@pytest.mark.parametrize(
    ('fields', 'likely'),
    [
        ({'x': 'double', 'percent_complete': 'float'}, 'percent_complete/100'),
        ({'distance_remaining': 'double', 'fraction_done': 'double'}, 'fraction_done'),
        ({'left_arm': 'double', 'steps_to_go': 'int32'}, 'steps_to_go'),
        ({'duration': 'double', 'iterations': 'int32', 'progress': 'string'}, None),
    ],
)
def test_words_of_a_name_count_and_not_their_letters(fields: dict[str, str], likely: str | None) -> None:
    class Feedback:
        def get_fields_and_field_types(self) -> dict[str, str]:
            return fields

    assert likely_field(Feedback()) == likely


def test_what_cannot_be_read_is_explained() -> None:
    with pytest.raises(ProgressError, match="'none' is not a number above 0; write FIELD or FIELD/MAX"):
        Progress('x/none')
    with pytest.raises(ProgressError, match="the feedback has no field 'w'; its fields are: x, y, z"):
        Progress('w').read(Point())
    with pytest.raises(ProgressError, match=r"the feedback has no field 'x\.y'"):
        Progress('x.y').read(Point())
