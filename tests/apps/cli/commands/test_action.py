"""ros2 action: its forms are ROS 2's; goals, cancel and watch are ours."""

from __future__ import annotations

import json
import re
import signal
import time
import uuid

import pytest
from helpers.command_line import Begin, CommandLine, on_dds_too

FIBONACCI = 'example_interfaces/action/Fibonacci'
ID = '[0-9a-f]{32}'


@on_dds_too
def test_list_type_find_info(ros2: CommandLine) -> None:
    assert ros2.ok('action', 'list') == '/lab/fibonacci\n'
    assert ros2.ok('action', 'list', '-t') == f'/lab/fibonacci [{FIBONACCI}]\n'
    assert ros2.ok('action', 'list', '-c') == '1\n'
    assert ros2.ok('action', 'type', 'lab/fibonacci') == f'{FIBONACCI}\n'
    assert ros2.ok('action', 'find', 'example_interfaces/Fibonacci') == '/lab/fibonacci\n'
    expected = (
        f'Action: /lab/fibonacci\nAction clients: 0\nAction servers: 1\n    /lab/workshop [{FIBONACCI}]\n'
    )
    assert ros2.ok('action', 'info', '/lab/fibonacci', '-t') == expected
    servers = json.loads(ros2.ok('action', 'info', '/lab/fibonacci', '--json'))['servers']
    assert servers == [{'node': '/lab/workshop', 'type': FIBONACCI}]


SENT = """Waiting for an action server to become available...
Sending goal:
     order: 3

Goal accepted with ID: <id>

"""
FEEDBACK = """Feedback:
    sequence:
- 0
- 1
- 1

Feedback:
    sequence:
- 0
- 1
- 1
- 2

"""
RESULT = """Result:
    sequence:
- 0
- 1
- 1
- 2

Goal finished with status: SUCCEEDED
"""


@on_dds_too
def test_send_goal_prints_what_ros_2_prints(ros2: CommandLine) -> None:
    out = ros2.ok('action', 'send_goal', '--feedback', '/lab/fibonacci', FIBONACCI, '{order: 3}')
    assert re.sub(ID, '<id>', out) == SENT + FEEDBACK + RESULT
    out = ros2.ok('action', 'send_goal', '/lab/fibonacci', FIBONACCI, 'order: 3')
    assert re.sub(ID, '<id>', out) == SENT + RESULT


def test_send_goal_as_json(ros2: CommandLine) -> None:
    lines = ros2.ok('action', 'send_goal', 'lab/fibonacci', 'order=2', '--json').splitlines()
    events = [json.loads(line) for line in lines]
    assert [each['event'] for each in events] == ['accepted', 'feedback', 'result']
    assert re.fullmatch(ID, events[0]['goal_id'])
    assert events[-1] == {'event': 'result', 'status': 'SUCCEEDED', 'result': {'sequence': [0, 1, 1]}}


def test_each_end_of_a_goal_has_its_code(ros2: CommandLine) -> None:
    aborted = ros2('action', 'send_goal', 'lab/fibonacci', 'order=13')
    assert (aborted.code, aborted.lines[-1]) == (8, 'Goal finished with status: ABORTED')
    rejected = ros2('action', 'send_goal', 'lab/fibonacci', 'order=-1')
    assert (rejected.code, rejected.lines[-1]) == (7, 'Goal was rejected.')
    late = ros2('action', 'send_goal', 'lab/fibonacci', 'order=1005', '--timeout', '1')
    assert (late.code, late.lines[-1]) == (5, 'Goal canceled.')
    told = "ros2: action '/lab/fibonacci' .* no answer came in time; waited .*; give it more time, see --help"
    assert re.fullmatch(told, late.err.rstrip('\n'))


def test_a_goal_that_is_cancelled_at_its_deadline_shows_how_it_ends(ros2: CommandLine) -> None:
    """Its server needs 0.3 s to end it."""
    late = ros2('action', 'send_goal', 'lab/fibonacci', 'order=5005', '--timeout', '0.5')
    assert late.code == 5
    assert late.out.index('Canceling goal...') < late.out.index('Result:') < late.out.index('Goal canceled.')


def test_what_is_wrong_is_said_in_one_line(ros2: CommandLine) -> None:
    known = 'lab/fibonacci'
    told = ros2.fails('action', 'send_goal', '/fibonacci', 'order=1', code=3)
    assert "did you mean '/lab/fibonacci'?" in told
    told = ros2.fails('action', 'send_goal', known, 'oder=1', code=4)
    assert "no field 'oder'; did you mean 'order'?" in told
    assert "there is no part 'X'" in ros2.fails('action', 'echo', known, '--interfaces', 'X', code=2)
    assert 'is not an id of a goal' in ros2.fails('action', 'cancel', known, 'xyz', code=4)
    assert 'required' in ros2.fails('action', 'cancel', known, code=2)
    assert 'is not a time' in ros2.fails('action', 'cancel', known, '--before', 'noon', code=4)
    assert 'no such goal' in ros2.fails('action', 'cancel', known, '0' * 31 + '1', code=3)


def test_ctrl_c_cancels_the_goal_and_waits_for_its_end(ros2: CommandLine, begin: Begin) -> None:
    goal = begin('action', 'send_goal', 'lab/fibonacci', 'order=1005')
    goal_id = goal.expect(f'Goal accepted with ID: ({ID})')[1]
    goal.send_signal(signal.SIGINT)
    assert goal.wait() == 9
    assert goal.output.splitlines()[-1] == 'Goal canceled.'
    assert 'Goal finished with status' not in goal.output  # that it is canceled is said once
    ended = json.loads(
        ros2.ok('action', 'goals', 'lab/fibonacci', '--all', '--json', '--timeout', '20').splitlines()[-1]
    )
    assert (ended['goal_id'], ended['status']) == (goal_id, 'CANCELED')


def test_a_second_ctrl_c_leaves(ros2: CommandLine, begin: Begin) -> None:
    goal = begin('action', 'send_goal', 'lab/fibonacci', 'order=3005')  # cancels it, and does not end
    goal.expect('Goal accepted')
    goal.send_signal(signal.SIGINT)
    goal.expect('^Canceling goal...$')
    time.sleep(0.3)  # signals that come together count as one
    goal.send_signal(signal.SIGINT)
    assert goal.wait() == 130
    assert goal.output.splitlines()[-1] == (
        'left without waiting, the goal may go on; see: ros2 action goals /lab/fibonacci'
    )


def test_a_server_that_does_not_cancel_is_told(ros2: CommandLine, begin: Begin) -> None:
    goal = begin('action', 'send_goal', 'lab/fibonacci', 'order=2005')
    goal.expect('Goal accepted')
    goal.send_signal(signal.SIGINT)
    assert goal.wait() == 7
    assert 'the server does not cancel the goal, which goes on; see: ros2 action goals' in goal.output


def test_a_server_that_says_nothing_to_a_cancel_request_is_told(ros2: CommandLine) -> None:
    ended = ros2('action', 'send_goal', 'lab/fibonacci', 'order=4005', '--timeout', '1')
    assert (ended.code, ended.lines[-1]) == (5, 'Canceling goal...')
    assert ended.err == (
        'ros2: the server did not answer the cancel request within 5 s; the goal may go on; '
        'see: ros2 action goals /lab/fibonacci\n'
    )
    ros2.ok('topic', 'pub', '-1', 'lab/orders', 'data=speak')  # else whoever cancels all goals waits for it


def test_goals_are_listed_and_cancelled(ros2: CommandLine, begin: Begin) -> None:
    first, second = (
        begin('action', 'send_goal', 'lab/fibonacci', f'order={order}') for order in (1005, 1006)
    )
    ids = [each.expect(f'Goal accepted with ID: ({ID})')[1] for each in (first, second)]
    listed = ros2.ok('action', 'goals', 'lab/fibonacci', '--timeout', '20').splitlines()
    for goal_id in ids:
        assert any(re.match(f'{goal_id}  EXECUTING  accepted at ', line) for line in listed)
    assert (
        ros2.ok('action', 'cancel', 'lab/fibonacci', ids[0][:12], '--timeout', '20')
        == f'Canceling goal {ids[0]}\n'
    )
    assert first.wait() == 9
    assert 'no goal to cancel' in ros2.fails('action', 'cancel', 'lab/fibonacci', '--before', '1h', code=3)
    assert f'Canceling goal {ids[1]}' in ros2.ok('action', 'cancel', 'lab/fibonacci', '--before', '0s')
    assert second.wait() == 9


@on_dds_too
def test_echo_shows_feedback_and_status(ros2: CommandLine, begin: Begin) -> None:
    ros2.ok('action', 'send_goal', 'lab/fibonacci', 'order=1')
    echo = begin('action', 'echo', 'lab/fibonacci', '--flow-style', '--qos-depth', '50')
    echo.expect('^interface: STATUS_TOPIC$')  # its history
    while not re.search('^interface: FEEDBACK_TOPIC$', echo.output, re.MULTILINE):
        ros2.ok('action', 'send_goal', 'lab/fibonacci', 'order=3')
    echo.expect('^  sequence: \\[0, 1, 1\\]$')


def test_watch_without_a_terminal_is_a_line_a_change(ros2: CommandLine, begin: Begin) -> None:
    ros2.ok('action', 'send_goal', 'lab/fibonacci', 'order=1')
    watch = begin('action', 'watch', 'lab/fibonacci', '--progress', 'sequence/10')
    watch.expect(f'^{ID} [A-Z]+$')  # what has ended before
    goal = begin('action', 'send_goal', 'lab/fibonacci', 'order=1005')
    goal_id = goal.expect(f'Goal accepted with ID: ({ID})')[1]
    watch.expect(f'^{goal_id} (ACCEPTED|EXECUTING)$')
    watch.expect(f'^{goal_id} feedback .*"sequence": \\[0, 1, 1\\].* 30 %$')
    goal.send_signal(signal.SIGINT)
    watch.expect(f'^{goal_id} CANCELED$')


@pytest.mark.parametrize('spec', ['nothing', 'sequence/0', 'sequence/x'])
def test_progress_needs_a_field_that_counts(ros2: CommandLine, spec: str) -> None:
    ros2_ended = ros2('action', 'send_goal', 'lab/fibonacci', 'order=3', '--progress', spec)
    assert ros2_ended.code == 4
    assert ros2_ended.err.count('\n') == 1


def test_a_detached_goal_is_probed_and_attached_to(ros2: CommandLine, begin: Begin) -> None:
    goal_id = ros2.ok('action', 'send_goal', 'lab/fibonacci', 'order=1005', '--detach').rstrip('\n')
    assert re.fullmatch(ID, goal_id)
    assert ros2.ok('action', 'probe', 'lab/fibonacci', goal_id[:12]) == f'{goal_id}: running, EXECUTING\n'
    attached = begin('action', 'attach', 'lab/fibonacci', goal_id)
    attached.expect(f'^Attached to goal {goal_id}$')
    left = begin('action', 'attach', 'lab/fibonacci', goal_id)
    left.expect('^Attached to goal')
    left.send_signal(signal.SIGINT)
    assert left.wait() == 130
    ros2.ok('action', 'cancel', 'lab/fibonacci', goal_id)
    assert attached.wait() == 9
    assert attached.output.splitlines()[-1] == 'Goal finished with status: CANCELED'
    ended = json.loads(ros2.ok('action', 'probe', 'lab/fibonacci', goal_id, '--json'))
    assert (ended['goal_id'], ended['state'], ended['status']) == (goal_id, 'ended', 'CANCELED')


def test_a_goal_of_a_given_id_runs_once_however_often_it_is_sent(ros2: CommandLine, begin: Begin) -> None:
    goal_id = uuid.uuid4()
    send = ('action', 'send_goal', 'lab/fibonacci', 'order=1005', '--goal-id')
    first = begin(*send, str(goal_id))
    first.expect(f'^Goal accepted with ID: {goal_id.hex}')
    assert ros2.ok(*send, goal_id.hex, '--detach') == f'{goal_id.hex}\n'
    second = begin(*send, goal_id.hex)
    second.expect(f'^The server has the goal {goal_id.hex}: nothing is sent$')
    ros2.ok('action', 'cancel', 'lab/fibonacci', goal_id.hex)
    for program in (first, second):
        assert program.wait() == 9
        assert program.output.splitlines()[-1] == 'Goal finished with status: CANCELED'
    third = ros2(*send, goal_id.hex, '--json')
    events = [json.loads(line) for line in third.lines]
    assert [each['event'] for each in events] == ['known', 'result']
    assert (third.code, events[1]['status']) == (9, 'CANCELED')


@pytest.mark.parametrize('given', ['4711', '0' * 32])
def test_what_is_no_id_of_a_goal_is_refused(ros2: CommandLine, given: str) -> None:
    told = ros2.fails('action', 'send_goal', 'lab/fibonacci', 'order=1', '--goal-id', given, code=2)
    assert given in told


def test_attaching_to_a_goal_that_the_server_does_not_have_sends_none(ros2: CommandLine) -> None:
    unknown = '0' * 31 + '1'
    told = ros2.fails('action', 'attach', 'lab/fibonacci', unknown, code=6)
    assert 'the server does not know the goal' in told
    assert f'action probe /lab/fibonacci {unknown}' in told
    assert 'does not have the goal' in ros2.fails('action', 'probe', 'lab/fibonacci', unknown, code=3)
    assert 'is not an id of a goal' in ros2.fails('action', 'attach', 'lab/fibonacci', '0' * 32, code=4)
    refused = ros2.fails('action', 'send_goal', 'lab/fibonacci', 'order=-1', '--detach', code=7)
    assert 'refused the goal' in refused
