"""The programs of examples/, as their first comments say to start them: each a process of its own."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.isolation import NETWORK, isolated_env
from helpers.processes import Program
from helpers.programs import server_of_programs

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[2] / 'examples'
SPINNING = {
    'talker': 'Said',
    'add_two_ints_server': 'Ready',
    'fibonacci_action_server': 'Ready',
    'timers': 'Tick 1',
    'parameters': 'Hello',
    'parameters_from_file': 'To home',
    'composed': '20.0 degrees',
    'clock_publisher': 'Time begins',
    'sim_time': "The time is the machine's",
    'custom_executor': 'Brake check 1',
    'lifecycle_talker': 'Unconfigured',
    'tf_broadcaster': 'Circling',
    'tf_listener': 'moon',
}
"""Programs that run until they are stopped, and what shows that they spin."""

Start: TypeAlias = Callable[..., Program]


@pytest.fixture
def start() -> Iterator[Start]:
    """`start(name, *arguments)` runs an example; all run in one world, and none outlives the test."""
    env = isolated_env(NETWORK)
    with ExitStack() as stack:
        yield lambda name, *arguments: stack.enter_context(
            Program(EXAMPLES / f'{name}.py', *arguments, env=env, server=server_of_programs())
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


def test_parameters_come_from_a_file_and_the_program_judges_what_is_set(start: Start) -> None:
    file = str(EXAMPLES / 'cruise.yaml')
    program = start('parameters_from_file', '--ros-args', '--params-file', file)
    program.expect('To kitchen at 1.5 m/s, 0.95 turns a second')
    program.expect('wheels.radius stays as it is: nobody changes wheels while driving')
    program.expect('To kitchen at 2.0 m/s')
    program.expect('speed stays as it is: .*2.5')


def test_composed_nodes_hear_each_other(start: Start) -> None:
    program = start('composed')
    for line in ('20.0 degrees', '25.0 degrees', '30.0 degrees: too hot'):
        program.expect(line)


def test_a_managed_node_talks_while_it_is_active(start: Start) -> None:
    talker = start('lifecycle_talker')
    assert start('lifecycle_manager', 'lc_talker').succeed().splitlines() == [
        'configure: done, inactive',
        'activate: done, active',
        'deactivate: done, inactive',
        'cleanup: done, unconfigured',
        'shutdown: done, finalized',
    ]
    for line in (
        'Unconfigured',
        'Configured: I was unconfigured',
        'Activated',
        'Saying number',
        'Deactivated',
    ):
        talker.expect(line)
    said = talker.output.splitlines()
    talker.expect('Cleaned up: I was inactive')
    talker.expect('Shut down: I was unconfigured')
    active = [index for index, line in enumerate(said) if 'Activated' in line or 'Deactivated' in line]
    assert all(active[0] < index < active[1] for index, line in enumerate(said) if 'Saying' in line)


def test_timers_and_sleeps_follow_simulated_time(start: Start) -> None:
    program = start('sim_time', '--ros-args', '-p', 'use_sim_time:=true')
    program.expect('The time is simulated')
    start('clock_publisher')
    program.expect('Slept 2 seconds')
    second = int(program.expect(r'It is second (\d+)')[1])
    assert 100 < second < 120
    program.expect(f'It is second {second + 1}')


def test_an_executor_of_ones_own_keeps_urgent_callbacks_on_time(start: Start) -> None:
    program = start('custom_executor')
    program.expect('Computing for a second')
    for _ in range(5):
        program.expect('Brake check')
    assert program.output.count('Computing for a second') == 1


def test_the_listener_learns_where_the_moon_is(start: Start) -> None:
    listener = start('tf_listener')
    listener.expect('Not seen yet')
    start('tf_broadcaster')
    for _ in range(2):
        listener.expect(r'The moon is at -?\d+.\d+, -?\d+.\d+: 3.0 from the earth')


@pytest.mark.parametrize('number', [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
def test_programs_end_quietly_when_they_are_stopped(start: Start, number: signal.Signals) -> None:
    programs = {name: start(name) for name in SPINNING}
    for name, program in programs.items():
        program.expect(SPINNING[name])
    for program in programs.values():  # only now: some need others to get there
        program.send_signal(number)
    for program in programs.values():
        assert 'Traceback' not in program.succeed()
