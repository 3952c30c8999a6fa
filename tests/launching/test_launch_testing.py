"""Launch tests: by the command `launch_test`, and under pytest."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from helpers.isolation import NETWORK
from helpers.patience import PATIENCE
from helpers.processes import Program
from launch_testing_ros import WaitForTopics
from rclpy.node import Node
from std_msgs.msg import String

COMMAND = (Path('-m'), 'goalwire', 'run', 'launch_testing', 'launch_test')
TALKER = f'''
import unittest

import launch_testing
import launch_testing.actions
import launch_testing.asserts
import launch_testing.util
import pytest
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

SCRIPT = """
import signal, sys, threading
sys.stdout.buffer.write(bytes([0xdd, 0xff, 10]))
print('ready for', sys.argv[1], flush=True)
stop = threading.Event()
signal.signal(signal.SIGINT, lambda *_: stop.set())
stop.wait()
print('bye', flush=True)
sys.exit(int(sys.argv[2]))
"""


@pytest.mark.launch_test
@launch_testing.parametrize('code', [CODES])
def generate_test_description(code):
    worker = ExecuteProcess(
        cmd=[{sys.executable!r}, '-c', SCRIPT, LaunchConfiguration('whom'), str(code)], name='worker'
    )
    return LaunchDescription([
        DeclareLaunchArgument('whom', default_value='everybody', description='Who is told'),
        worker,
        launch_testing.actions.ReadyToTest(),
    ]), {{'worker': worker}}


class TestWhileItRuns(unittest.TestCase):
    def test_it_says_that_it_is_ready(self, proc_info, proc_output, worker, test_args):
        proc_info.assertWaitForStartup(process=worker, timeout=20)
        whom = test_args.get('whom', 'everybody')
        proc_output.assertWaitFor(f'ready for {{whom}}', process=worker, stream='stdout', timeout=20)
        self.assertFalse(proc_output.waitFor('bye', process=worker, stream='stdout', timeout=0))


@launch_testing.post_shutdown_test()
class TestWhenItHasEnded(unittest.TestCase):
    def test_it_says_good_bye(self, proc_info, proc_output, worker, code):
        with launch_testing.asserts.assertSequentialStdout(proc_output, worker) as checker:
            checker.assertInStdout('ready for')
            checker.assertInStdout('bye')
        launch_testing.asserts.assertExitCodes(proc_info, process=worker)
'''


WITHOUT_READY = """
from launch import LaunchDescription

def generate_test_description():
    return LaunchDescription([])
"""


@pytest.fixture
def transport_name() -> str:
    """No program here uses a wire."""
    return NETWORK


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / 'test_worker.py'


def test_all_launches_of_a_file_are_run_and_reported(isolated: dict[str, str], file: Path) -> None:
    file.write_text(TALKER.replace('CODES', '0, 7'))
    report = file.with_suffix('.xml')
    with Program(*COMMAND, str(file), '--junit-xml', str(report), 'whom:=me', env=isolated) as program:
        assert program.wait() == 1
    assert 'Starting test run test_worker.test_worker.launch_tests[7]' in program.output
    assert 'Proc worker-2 exited with code 7' in program.output
    suites = ET.parse(report).getroot()
    assert (suites.get('tests'), suites.get('failures'), suites.get('errors')) == ('4', '1', '0')
    [failed] = [case for case in suites.iter('testcase') if case.find('failure') is not None]
    assert failed.get('name') == 'test_it_says_good_bye[7]'


def test_arguments_are_shown(isolated: dict[str, str], file: Path) -> None:
    file.write_text(TALKER.replace('CODES', '0'))
    with Program(*COMMAND, str(file), '--show-args', env=isolated) as program:
        assert 'whom: Who is told' in program.succeed()


def test_pytest_runs_a_marked_file_as_one_test(isolated: dict[str, str], file: Path) -> None:
    file.write_text(TALKER.replace('CODES', '0'))
    words = ('pytest', '-p', 'no:cacheprovider', '-c', '/dev/null', '--rootdir', str(file.parent))
    with Program(Path('-m'), *words, str(file), '--launch-args', 'whom:=me', env=isolated) as program:
        assert '1 passed' in program.succeed()


def test_pytest_shows_which_test_of_a_launch_failed(isolated: dict[str, str], file: Path) -> None:
    file.write_text(TALKER.replace('CODES', '3'))
    words = ('pytest', '-p', 'no:cacheprovider', '-c', '/dev/null', '--rootdir', str(file.parent))
    with Program(Path('-m'), *words, str(file), env=isolated) as program:
        assert program.wait() == 1
    assert 'test_it_says_good_bye[3]' in program.output
    assert 'Proc worker-1 exited with code 3' in program.output
    assert '1 failed' in program.output


@pytest.mark.parametrize(
    ('text', 'complaint'),
    [
        ('x = 1', 'has no function generate_test_description'),
        (WITHOUT_READY, 'containing a ReadyToTest action'),
        ('def generate_test_description(a): ...', "unexpected extra argument 'a'"),
    ],
)
def test_a_file_that_tests_nothing_is_told(
    isolated: dict[str, str], file: Path, text: str, complaint: str
) -> None:
    file.write_text(text)
    with Program(*COMMAND, str(file), env=isolated) as program:
        assert program.wait() != 0
    assert complaint in program.output
    assert 'Traceback' not in program.output


def test_a_launch_that_ends_too_early_fails_its_tests(isolated: dict[str, str], file: Path) -> None:
    file.write_text(
        'import unittest, launch_testing.actions\n'
        'from launch import LaunchDescription\n'
        'from launch.actions import ExecuteProcess\n'
        'def generate_test_description():\n'
        f'    died = ExecuteProcess(cmd=[{sys.executable!r}, "-c", "raise SystemExit(4)"])\n'
        '    return LaunchDescription([died, launch_testing.actions.ReadyToTest()]), {"died": died}\n'
        'class TestIt(unittest.TestCase):\n'
        '    def test_output(self, proc_output):\n'
        '        proc_output.assertWaitFor("never", timeout=20)\n'
    )
    with Program(*COMMAND, str(file), env=isolated) as program:
        assert program.wait() == 1
    assert 'Processes under test stopped before tests completed' in program.output
    assert 'exited with 4' in program.output


ROS_TEST = f'''
import sys
import unittest

import launch_ros.actions
import launch_testing.actions
import launch_testing_ros
import pytest
import rclpy
from launch import LaunchDescription
from launch_testing_ros import DataRepublisher, MessagePump, WaitForTopics
from std_msgs.msg import String

TALKER = """
import goalwire, asyncio
from std_msgs.msg import String

async def main():
    async with goalwire.Node('talker') as node:
        publisher = node.publisher(String, 'chatter')
        async for _ in node.timer(0.05):
            publisher.publish(data='hello')

asyncio.run(main())
"""


@pytest.mark.rostest
def generate_test_description():
    talker = launch_ros.actions.Node(executable={sys.executable!r}, arguments=['-c', TALKER], name='talker')
    return LaunchDescription([talker, launch_testing.actions.ReadyToTest()])


class TestTalker(unittest.TestCase):
    def test_topics_are_waited_for(self):
        with WaitForTopics([('chatter', String)], timeout=20.0) as found:
            assert found.topics_received() == {{'chatter'}}
            assert found.topics_not_received() == set()
            assert found.received_messages('chatter')[-1].data == 'hello'
            self.assertRaises(KeyError, found.received_messages, 'other')
            assert found.wait()  # once more

    def test_a_topic_without_messages_is_named(self):
        both = [('chatter', String), ('silent', String)]
        with self.assertRaisesRegex(RuntimeError, 'silent'), WaitForTopics(both, timeout=1.0):
            pass

    def test_messages_are_changed_on_their_way(self):
        rclpy.init()
        node = rclpy.create_node('test')
        pump = MessagePump(node)
        pump.start()
        odd = lambda message: String(data='aloha') if changer.get_num_received() % 2 else None
        changer = DataRepublisher(node, 'chatter', 'changed', String, odd)
        with WaitForTopics([('changed', String)], timeout=20.0) as found:
            assert found.received_messages('changed')[0].data == 'aloha'
        assert changer.get_num_republished() <= changer.get_num_received()
        assert changer.get_republished()[0].data == 'hello'
        changer.shutdown()
        pump.stop()
        rclpy.shutdown()

    def test_filters_know_rmw_implementations(self):
        keep = launch_testing_ros.tools.basic_output_filter(filtered_rmw_implementation='rmw_zenoh_cpp')
        assert keep('pid 7\\nhello\\n') == 'hello\\n'
'''


@pytest.mark.slow
def test_nodes_are_tested_under_pytest(isolated: dict[str, str], tmp_path: Path) -> None:
    """The mark `rostest` means what `launch_test` means."""
    file = tmp_path / 'test_talker.py'
    file.write_text(ROS_TEST, encoding='utf-8')
    words = ('pytest', '-p', 'no:cacheprovider', '-c', '/dev/null', '--rootdir', str(tmp_path), '-W', 'error')
    with Program(Path('-m'), *words, str(file), env=isolated) as program:
        assert '1 passed' in program.succeed(60)


def test_a_message_that_comes_early_is_not_taken_for_all(
    isolated: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first topic has its message before the second is subscribed to."""
    create = Node.create_subscription

    def subscribe(
        node: Node, cls: type[String], topic: str, callback: Callable[[String], None], qos: int
    ) -> None:
        taken = threading.Event()

        def take(message: String) -> None:
            callback(message)
            taken.set()

        create(node, cls, topic, take, qos)
        if topic == 'chatter':
            node.create_publisher(String, topic, 10).publish(String(data='early'))
            assert taken.wait(PATIENCE)

    monkeypatch.setattr(Node, 'create_subscription', subscribe)
    waiting = WaitForTopics([('chatter', String), ('silent', String)], timeout=0.0)
    try:
        assert not waiting.wait()
        assert waiting.topics_not_received() == {'silent'}
    finally:
        waiting.shutdown()
