"""Tests the action server and client of examples/: minutes of counting, in no time."""

import fibonacci_action_client
import fibonacci_action_server
import pytest
from example_interfaces.action import Fibonacci

from goalwire import DeadlineError, GoalRefused


def test_the_server_counts_one_number_every_half_second(gw_clock, gw_graph):
    gw_graph.run(fibonacci_action_server.main, node='fibonacci_action_server')
    outcome = gw_graph.send_goal(Fibonacci, 'fibonacci', order=46)
    assert len(outcome.feedback) == 45
    assert outcome.result.sequence[-1] == 1836311903
    assert gw_clock.elapsed == 22.5


@pytest.mark.parametrize('order', [0, -1, 47])
def test_the_server_refuses_what_it_cannot_count(gw_clock, gw_graph, order):
    gw_graph.run(fibonacci_action_server.main, node='fibonacci_action_server')
    with pytest.raises(GoalRefused):
        gw_graph.send_goal(Fibonacci, 'fibonacci', order=order)


def test_the_server_lets_go_of_a_goal_that_nobody_wants_any_more(gw_clock, gw_graph):
    gw_graph.run(fibonacci_action_server.main, node='fibonacci_action_server')
    with pytest.raises(DeadlineError):
        gw_graph.send_goal(Fibonacci, 'fibonacci', order=40, timeout=3.2)
    assert gw_clock.elapsed == 3.5  # it looks every half second


def test_the_client_shows_what_it_is_told(gw_clock, gw_graph, capsys):
    steps = [Fibonacci.Feedback(sequence=[0, 1]), Fibonacci.Feedback(sequence=[0, 1, 1])]
    action = gw_graph.action(
        Fibonacci, 'fibonacci', feedback=steps, result=Fibonacci.Result(sequence=[0, 1, 1])
    )
    assert gw_graph.run(fibonacci_action_client.main, '2').wait() == 0
    action.assert_goal(order=2)
    assert capsys.readouterr().out.splitlines() == [
        'So far: [0, 1]',
        'So far: [0, 1, 1]',
        'Result: [0, 1, 1]',
        'The goal succeeded',
    ]


def test_the_client_cancels_when_it_has_had_enough(gw_clock, gw_graph):
    action = gw_graph.action(Fibonacci, 'fibonacci', never_ends=True)
    assert gw_graph.run(fibonacci_action_client.main, '2', '--cancel-after', '30').wait(timeout=60) == 0
    assert action.endings == ['canceled']
    assert gw_clock.elapsed == 30.0
