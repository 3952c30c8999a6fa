"""The programs of examples/, as their first comments say to start them: each a process of its own."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[2] / 'examples'
SPINNING = {
    'talker': 'Said',
    'add_two_ints_server': 'Ready',
    'fibonacci_action_server': 'Ready',
    'timers': 'Tick 1',
    'parameters': 'Hello',
}
"""Programs that run until they are stopped, and what shows that they spin."""

Start: TypeAlias = Callable[..., Program]


@pytest.fixture
def start() -> Iterator[Start]:
    """`start(name, *arguments)` runs an example; all run in one world, and none outlives the test."""
    env = isolated_env('rmw_zenoh_cpp')
    with ExitStack() as stack:
        yield lambda name, *arguments: stack.enter_context(
            Program(EXAMPLES / f'{name}.py', *arguments, env=env)
        )


@pytest.mark.parametrize(('first', 'second'), [('talker', 'listener'), ('listener', 'talker')])
def test_the_listener_hears_the_talker_in_either_start_order(start: Start, first: str, second: str) -> None:
    programs = {first: start(first), second: start(second)}
    number = int(programs['listener'].expect(r'Heard: Hello number (\d+)')[1])
    programs['listener'].expect(f'Heard: Hello number {number + 1}$')


def test_a_remapped_talker_is_heard_under_the_new_name_alone(start: Start) -> None:
    start('talker', '--ros-args', '-r', 'chatter:=news')
    start('listener', '--ros-args', '-r', 'chatter:=news').expect('number 3$')
    plain = start('listener')
    start('talker')
    heard = [int(plain.expect(r'Heard: Hello number (\d+)')[1]) for _ in range(3)]
    assert heard == list(range(heard[0], heard[0] + 3)), 'two talkers would count in turns'


def test_the_client_gets_its_sum_from_a_running_server(start: Start) -> None:
    start('add_two_ints_server').expect('Ready')
    assert start('add_two_ints_client', '2', '3').succeed().endswith('2 + 3 = 5')


def test_the_client_waits_for_a_server_that_comes_later(start: Start) -> None:
    client = start('add_two_ints_client', '40', '2')
    start('add_two_ints_server')
    assert client.succeed().endswith('40 + 2 = 42')


def test_the_client_says_how_it_is_used(start: Start) -> None:
    client = start('add_two_ints_client', '2')
    assert client.wait() == 1
    assert client.output == 'usage: add_two_ints_client.py A B'


def test_a_goal_shows_its_feedback_and_its_result(start: Start) -> None:
    start('fibonacci_action_server')
    client = start('fibonacci_action_client', '4')
    assert client.succeed().splitlines() == [
        'So far: [0, 1, 1]',
        'So far: [0, 1, 1, 2]',
        'So far: [0, 1, 1, 2, 3]',
        'Result: [0, 1, 1, 2, 3]',
        'The goal succeeded',
    ]


def test_a_goal_is_cancelled_after_the_given_time(start: Start) -> None:
    server = start('fibonacci_action_server')
    client = start('fibonacci_action_client', '40', '--cancel-after', '0.7')
    assert client.succeed().endswith('The goal was cancelled')
    server.expect('Cancelled')


@pytest.mark.parametrize('order', ['0', '47'])
def test_a_goal_that_cannot_be_counted_is_refused(start: Start, order: str) -> None:
    start('fibonacci_action_server')
    client = start('fibonacci_action_client', order)
    assert client.wait() == 1
    assert client.output == 'The goal was refused'


def test_a_timer_pauses_and_goes_on(start: Start) -> None:
    timers = start('timers')
    for line in ('Tick 1$', 'Paused', 'Going on', 'Tick'):
        timers.expect(line)


def test_parameters_come_from_the_command_line_and_keep_their_type(start: Start) -> None:
    program = start('parameters', '--ros-args', '-p', 'whom:=moon', '-p', 'period:=0.1')
    program.expect("stays a string: Wrong parameter type, expected 'Type.STRING' got 'Type.INTEGER'")
    program.expect('Hello moon$')
    program.expect('Hello moon!$')


@pytest.mark.parametrize('name', SPINNING)
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_program_ends_quietly_when_it_is_stopped(start: Start, name: str, number: signal.Signals) -> None:
    program = start(name)
    program.expect(SPINNING[name])
    program.send_signal(number)
    assert 'Traceback' not in program.succeed()
