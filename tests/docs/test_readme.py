"""The README's two programs serve whoever calls them."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.markdown import ROOT, blocks
from helpers.processes import Program

from goalwire.rules.goals.states import GoalStatus

pytestmark = pytest.mark.slow

SERVERS = ('lamp.py', 'counter.py')
READY = '[lamp]: ready: /switch turns it on and off'
PROGRAMS = {block.title: block.text for block in blocks(ROOT / 'README.md') if block.title in SERVERS}

SWITCH = """
    import rclpy
    from std_srvs.srv import SetBool

    with rclpy.init():
        client = rclpy.create_node('finger').create_client(SetBool, 'switch')
        assert client.wait_for_service(timeout_sec=10)
        for data in (True, False):
            print(client.call(SetBool.Request(data=data), timeout_sec=5).message)
"""

COUNT = """
    import sys, rclpy
    from example_interfaces.action import Fibonacci
    from rclpy.action import ActionClient

    def wait_for(future):
        rclpy.spin_until_future_complete(node, future, timeout_sec=10)
        return future.result()

    def hear(message):
        seen.append(list(message.feedback.sequence))
        if goal is not None and 'cancel' in sys.argv:
            goal.cancel_goal_async()

    with rclpy.init():
        goal, seen = None, []
        node = rclpy.create_node('pupil')
        client = ActionClient(node, Fibonacci, 'count')
        assert client.wait_for_server(timeout_sec=10)
        order = int(sys.argv[1])
        goal = wait_for(client.send_goal_async(Fibonacci.Goal(order=order), feedback_callback=hear))
        answer = wait_for(goal.get_result_async())
        print(answer.status, seen[:3], list(answer.result.sequence) == seen[-1], len(seen) == order - 1)
"""
MEETS = {
    'lamp.py': SWITCH,
    'counter.py': """
        import rclpy
        from example_interfaces.action import Fibonacci
        from rclpy.action import ActionClient

        with rclpy.init():
            client = ActionClient(rclpy.create_node('pupil'), Fibonacci, 'count')
            assert client.wait_for_server(timeout_sec=10)
    """,
}
FIRST = '[[0, 1, 1], [0, 1, 1, 2], [0, 1, 1, 2, 3]]'


def test_the_service_takes_15_lines_and_the_action_25() -> None:
    lines = {name: len([line for line in text.splitlines() if line]) for name, text in PROGRAMS.items()}
    assert lines.keys() == {'lamp.py', 'counter.py'}
    assert lines['lamp.py'] <= 15
    assert lines['counter.py'] <= 25


def test_the_service_answers(tmp_path: Path) -> None:
    (tmp_path / 'lamp.py').write_text(PROGRAMS['lamp.py'], encoding='utf-8')
    env = isolated_env('rmw_zenoh_cpp')
    with Program(tmp_path / 'lamp.py', env=env), Program(SWITCH, env=env) as client:
        assert client.succeed().splitlines() == ['on', 'off']


def _count(folder: Path, *arguments: str) -> str:
    (folder / 'counter.py').write_text(PROGRAMS['counter.py'], encoding='utf-8')
    env = isolated_env('rmw_zenoh_cpp')
    with Program(folder / 'counter.py', env=env), Program(COUNT, *arguments, env=env) as client:
        return client.succeed()


def test_the_action_counts_to_its_end(tmp_path: Path) -> None:
    assert _count(tmp_path, '5') == f'{GoalStatus.SUCCEEDED} {FIRST} True True'


def test_the_action_is_cancelled_on_the_way(tmp_path: Path) -> None:
    status, *_, result_is_last_feedback, has_counted_all = _count(tmp_path, '40', 'cancel').split()
    assert (status, result_is_last_feedback, has_counted_all) == (f'{GoalStatus.CANCELED}', 'True', 'False')


@pytest.mark.parametrize('rmw', ['rmw_zenoh_cpp', 'rmw_cyclonedds_cpp'])
@pytest.mark.parametrize('name', SERVERS)
def test_ctrl_c_ends_a_server_without_another_word(tmp_path: Path, name: str, rmw: str) -> None:
    (tmp_path / name).write_text(PROGRAMS[name], encoding='utf-8')
    env = isolated_env(rmw)
    with Program(tmp_path / name, env=env) as server:
        with Program(MEETS[name], env=env) as client:
            client.succeed()
        server.send_signal(signal.SIGINT)
        server.wait()
    assert [line for line in server.output.splitlines() if not line.endswith(READY)] == []
