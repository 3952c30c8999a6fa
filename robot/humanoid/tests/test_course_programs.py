"""The chapter's four programs, run as it tells: server and client in two terminals."""

from __future__ import annotations

import runpy
import signal
import time

import pytest
from goalwire.logging import LogRecord
from goalwire.testing import Graph, VirtualClock
from helpers.robot import COURSE, course

pytestmark = pytest.mark.slow


@pytest.mark.parametrize('server_first', [True, False])
def test_the_service_client_reads_three_joints(world: dict[str, str], server_first: bool) -> None:
    names = ['joint_state_service', 'joint_state_client']
    first, second = names if server_first else reversed(names)
    with course(first, env=world) as one, course(second, env=world) as two:
        server, client = (one, two) if server_first else (two, one)
        client.expect('Joint: left_arm_shoulder, Position: 0.500, Velocity: 0.000')
        client.expect('Joint: right_knee, Position: 0.000, Velocity: 0.000')
        client.expect('Joint: left_knee, Position: 0.000, Velocity: 0.000')
        assert client.wait() == 0
        server.expect('Served joint state for: left_knee')


def test_the_service_client_says_that_it_waits(world: dict[str, str]) -> None:
    with course('joint_state_client', env=world) as client:
        client.expect('Service not available, waiting...')


def test_the_action_client_follows_its_goal_to_the_result(
    gw_clock: VirtualClock, gw_graph: Graph, records: list[LogRecord]
) -> None:
    """The goal takes its whole timeout of 30 s, here in virtual time."""
    server, client = (
        runpy.run_path(str(COURSE / f'navigation_action_{side}.py')) for side in ('server', 'client')
    )
    gw_graph.start(server['NavigationActionServer'])
    gw_graph.start(client['NavigationActionClient']).send_goal(1.0, 2.0, 0.0)
    while not any(record.message.startswith('Result: ') for record in records):
        time.sleep(1.0)  # in virtual time
    assert gw_clock.elapsed == pytest.approx(30.0, abs=2.0)
    told = [record.message for record in records]
    assert told[-1] == 'Result: Success=True, Message=Navigation completed successfully'
    assert 'Feedback: Position=(0.50, 1.00), Distance=1.12m' in told
    assert 'Navigation goal completed' in told


@pytest.mark.long
def test_the_action_client_follows_its_goal_in_another_process(world: dict[str, str]) -> None:
    """The goal takes its whole timeout of 30 s. Feedback is a topic: on DDS it may overtake the answer."""
    with (
        course('navigation_action_server', env=world) as server,
        course('navigation_action_client', env=world) as client,
    ):
        client.expect(r'Sending goal: \(1.0, 2.0, 0.0\)')
        client.expect(r'Feedback: Position=\(0\.00, 0\.00\), Distance=2\.24m')
        client.expect(r'Feedback: Position=\(0\.50, 1\.00\), Distance=1\.1\dm', timeout=30.0)
        client.expect('Result: Success=True, Message=Navigation completed successfully', timeout=30.0)
        assert 'Goal accepted' in client.output
        server.expect('Executing navigation goal')
        server.expect('Navigation goal completed')


def test_the_action_client_may_be_started_first(world: dict[str, str]) -> None:
    with course('navigation_action_client', env=world) as client:
        client.expect('Waiting for action server...')
        with course('navigation_action_server', env=world):
            client.expect(r'Sending goal: \(1.0, 2.0, 0.0\)')
            client.expect(r'Feedback: Position=\(0\.\d\d, 0\.\d\d\), Distance=2\.\d\dm')


@pytest.mark.parametrize('name', ['joint_state_service', 'navigation_action_server'])
def test_a_server_of_the_chapter_ends_on_ctrl_c_with_rclpys_status_and_without_a_traceback(
    world: dict[str, str], name: str
) -> None:
    with course(name, env=world) as server:
        server.expect('ready')
        server.send_signal(signal.SIGINT)
        assert server.wait() == -signal.SIGINT
        assert 'KeyboardInterrupt' not in server.output
