"""Actions between goalwire and plain zenoh programs written from rmw_zenoh's documents."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.processes import Program
from helpers.programs import Start, programs_in

Run: TypeAlias = Callable[..., Program]
DATA = Path(__file__).parents[1] / 'data'


@pytest.fixture(scope='module')
def hashes() -> str:
    """The hashes of an action's five types as real ROS 2 computes them, for the plain programs."""
    known = json.loads((DATA / 'vectors' / 'type_hashes.json').read_text())
    action = 'example_interfaces/action/Fibonacci'
    return json.dumps(
        {
            'send_goal': known[f'{action}_SendGoal'],
            'get_result': known[f'{action}_GetResult'],
            'cancel_goal': known['action_msgs/srv/CancelGoal'],
            'feedback': known[f'{action}_FeedbackMessage'],
            'status': known['action_msgs/msg/GoalStatusArray'],
        }
    )


@pytest.fixture
def start(world: dict[str, str]) -> Iterator[Start]:
    """A function that starts a program written for rclpy."""
    with programs_in(world) as start:
        yield start


def test_a_plain_zenoh_client_has_goals_done_cancelled_aborted_and_refused(
    start: Start, run: Run, hashes: str
) -> None:
    start('fibonacci_server').expect('ready')
    output = run('raw_action_client', hashes).succeed()
    assert output == 'one goal succeeded\none goal was canceled\none goal was aborted\none goal was refused'


def test_a_plain_zenoh_server_does_cancels_and_refuses_our_goals(start: Start, run: Run, hashes: str) -> None:
    run('rendezvous').expect('ready')
    run('raw_action_server', hashes).expect('ready')
    output = start('fibonacci_client').succeed()
    assert 'succeeded [0, 1, 1, 2, 3, 5, 8] after 5 feedback messages' in output
    assert 'canceled with return code 0, 1 goal canceling, [0, 1, 1, 2, 3]' in output
    assert 'refused' in output
