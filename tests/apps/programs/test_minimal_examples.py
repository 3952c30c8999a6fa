"""The minimal examples of ROS 2, and the tutorials' action."""

from __future__ import annotations

from apps.programs.conftest import Run

EXAMPLES = 'examples_rclpy_minimal_'


def test_publisher_and_subscriber(run: Run) -> None:
    subscriber = run(f'{EXAMPLES}subscriber', 'subscriber_member_function')
    run(f'{EXAMPLES}publisher', 'publisher_old_school')
    subscriber.expect('I heard: "Hello World: ')


def test_service_and_client(run: Run) -> None:
    run(f'{EXAMPLES}service', 'service')
    client = run(f'{EXAMPLES}client', 'client_async')
    client.expect(r'Result of add_two_ints: for 41 \+ 1 = 42')
    assert client.wait() == 0


def test_a_goal_is_cancelled(run: Run) -> None:
    server = run(f'{EXAMPLES}action_server', 'server')
    client = run(f'{EXAMPLES}action_client', 'client_cancel')
    client.expect('Goal accepted')
    client.expect(r'Received feedback: \[0, 1, 1\]')
    client.expect('Goal successfully canceled')
    assert client.wait() == 0
    server.expect('Goal canceled')


def test_the_action_of_the_tutorials(run: Run) -> None:
    run('action_tutorials_py', 'fibonacci_action_server')
    client = run('action_tutorials_py', 'fibonacci_action_client')
    client.expect(r'Received feedback: \[0, 1, 1\]')
