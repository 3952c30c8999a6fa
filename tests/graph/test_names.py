"""The facts that names in the graph tell by their form."""

from __future__ import annotations

import pytest

from goalwire.graph.names import actions_among, without_hidden
from goalwire.rules.names import is_hidden_name


@pytest.mark.parametrize(
    ('name', 'hidden'),
    [
        ('/chatter', False),
        ('/_chatter', True),
        ('/robot/_private/state', True),
        ('/fib/_action/feedback', True),
        ('/snake_case_', False),
        ('_daemon', True),
        ('/', False),
    ],
)
def test_a_token_that_starts_with_an_underscore_hides_the_name(name: str, hidden: bool) -> None:
    assert is_hidden_name(name) is hidden


def test_hidden_names_are_left_out_of_a_list() -> None:
    assert without_hidden([('/a', ['x']), ('/_b', ['x'])]) == [('/a', ['x'])]


def test_actions_are_recognised_by_their_feedback_topics() -> None:
    topics = [
        ('/walk/_action/feedback', ['p/action/Walk_FeedbackMessage']),
        ('/walk/_action/status', ['action_msgs/msg/GoalStatusArray']),
        ('/feedback', ['p/msg/Feedback']),
    ]
    assert actions_among(topics) == [('/walk', ['p/action/Walk'])]
