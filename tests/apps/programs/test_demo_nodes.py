"""The programs of ROS 2's first tutorials, as processes that meet each other."""

from __future__ import annotations

import signal

import pytest
from apps.programs.conftest import Run


def test_a_talker_in_cpp_and_a_listener_in_python(run: Run) -> None:
    listener = run('demo_nodes_py', 'listener')
    talker = run('demo_nodes_cpp', 'talker')
    talker.expect(r"\[talker\]: Publishing: 'Hello World: 1'")
    listener.expect(r'\[listener\]: I heard: \[Hello World: \d+\]')
    talker.send_signal(signal.SIGINT)
    assert talker.wait() == 0
    assert 'Traceback' not in talker.output


def test_a_launch_file_gives_the_talker_another_name_and_topic(run: Run) -> None:
    listener = run('demo_nodes_cpp', 'listener_best_effort', '--ros-args', '-r', 'chatter:=news')
    talker = run('demo_nodes_py', 'talker', '--ros-args', '-r', '__node:=herald', '-r', 'chatter:=news')
    talker.expect(r'\[herald\]: Publishing: "Hello World: 0"')
    listener.expect('I heard: ')


def test_talker_qos_ends_after_its_cycles(run: Run) -> None:
    listener = run('demo_nodes_py', 'listener_qos', '--reliable', '-n', '1')
    talker = run('demo_nodes_py', 'talker_qos', '--reliable')
    listener.expect('Reliable listener')
    listener.expect('I heard: ')
    assert listener.wait() == 0
    assert 'Hello World: 0' in talker.output


@pytest.mark.parametrize('package', ['demo_nodes_cpp', 'demo_nodes_py'])
def test_a_client_adds_two_ints(run: Run, package: str) -> None:
    server = run(package, 'add_two_ints_server')
    client = run(package, 'add_two_ints_client', '40', '2')
    client.expect('Result of add_two_ints: 42')
    assert client.wait() == 0
    server.expect('a: 40 b: 2')


def test_a_client_without_numbers_says_what_it_needs(run: Run) -> None:
    client = run('demo_nodes_cpp', 'add_two_ints_client', 'one', '2')
    assert client.wait() == 1
    assert client.output == 'usage: add_two_ints_client [A B], two numbers of 64 bits'


def test_the_blackboard_takes_any_parameter(run: Run) -> None:
    board = run('demo_nodes_cpp', 'parameter_blackboard', '--ros-args', '-p', 'colour:=red')
    board.expect(
        r"Parameter blackboard node named '/parameter_blackboard' ready, and serving '\d+' parameters"
    )


def test_timers_are_cancelled_and_started_anew(run: Run) -> None:
    once, again = run('demo_nodes_cpp', 'one_off_timer'), run('demo_nodes_cpp', 'reuse_timer')
    once.expect('in periodic_timer callback')
    once.expect('in one_off_timer callback')
    again.expect('  resetting one off timer')
    again.expect('in one_off_timer callback')
