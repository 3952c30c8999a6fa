"""Programs for transforms."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from apps.programs.conftest import Run
from geometry_msgs.msg import TransformStamped
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_ros import BufferClient, TransformException

from goalwire.apps.programs.running import UsageError
from goalwire.apps.programs.tf2.echo import describe
from goalwire.apps.programs.tf2.static_transform_publisher import read_arguments
from goalwire.apps.programs.tf2.view_frames import draw

FRAMES = ('--frame-id', 'world', '--child-frame-id', 'base')


def test_flags_make_a_transform() -> None:
    found = read_arguments(['--x', '1', '--yaw', '3.141592653589793', *FRAMES])
    assert (found.transform.translation.x, found.transform.translation.y) == (1.0, 0.0)
    assert found.transform.rotation.z == pytest.approx(1.0)
    assert (found.header.frame_id, found.child_frame_id) == ('world', 'base')


@pytest.mark.parametrize(
    ('words', 'z', 'w'),
    [
        (['-1', '2', '3', '3.141592653589793', '0', '0', 'world', 'base'], 1.0, 0.0),
        (['-1', '2', '3', '0', '0', '0', '1', 'world', 'base'], 0.0, 1.0),
    ],
)
def test_the_old_style_has_yaw_first_or_a_quaternion(words: list[str], z: float, w: float) -> None:
    found = read_arguments(words).transform
    assert (found.translation.x, found.translation.y, found.translation.z) == (-1.0, 2.0, 3.0)
    assert found.rotation.z == pytest.approx(z)
    assert found.rotation.w == pytest.approx(w)


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (['--x', '1'], '--frame-id must be given'),
        (['--x', 'one', *FRAMES], "x is 'one': it must be a number"),
        (['--x', 'nan', *FRAMES], "x is 'nan': it must be a number"),
        (['--qw', '0', *FRAMES], 'a quaternion of length 0 is not a rotation'),
        (['--yaw', '1', '--qw', '1', *FRAMES], 'a quaternion and angles cannot be given together'),
        (['base', *FRAMES], "'base' is not understood"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(words: list[str], reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        read_arguments(words)


def test_a_transform_is_shown_in_every_form() -> None:
    transform = TransformStamped()
    transform.header.stamp.sec = 7
    transform.transform.translation.x = 1.0
    transform.transform.rotation.z = transform.transform.rotation.w = 0.5**0.5
    assert describe(transform) == [
        'At time 7.0',
        '- Translation: [1.000, 0.000, 0.000]',
        '- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.707, 0.707]',
        '- Rotation: in RPY (radian) [0.000, -0.000, 1.571]',
        '- Rotation: in RPY (degree) [0.000, -0.000, 90.000]',
        '- Matrix:',
        '  0.000 -1.000  0.000  1.000',
        '  1.000  0.000  0.000  0.000',
        '  0.000  0.000  1.000  0.000',
        '  0.000  0.000  0.000  1.000',
    ]


def test_a_static_transform_is_echoed(run: Run) -> None:
    publisher = run('tf2_ros', 'static_transform_publisher', '--x', '1', *FRAMES)
    publisher.expect("from 'world' to 'base'")
    echo = run('tf2_ros', 'tf2_echo', 'world', 'base', '20')
    echo.expect(r'- Translation: \[1.000, 0.000, 0.000\]')


def test_an_unknown_frame_is_waited_for(run: Run) -> None:
    echo = run('tf2_ros', 'tf2_echo', 'world', 'base', '20')
    echo.expect('Waiting for transform world ->  base: ')
    run('tf2_ros', 'static_transform_publisher', '0', '0', '1', '0', '0', '0', 'world', 'base')
    echo.expect(r'- Translation: \[0.000, 0.000, 1.000\]')


def test_the_tree_is_drawn(run: Run, tmp_path: Path) -> None:
    run('tf2_ros', 'static_transform_publisher', *FRAMES).expect('Spinning')
    view = run('tf2_tools', 'view_frames', '--wait-time', '1', '--output', 'tree')
    assert view.wait() == 0
    assert '"world" -> "base"' in (tmp_path / 'tree.gv').read_text()


def test_a_tree_is_written_in_graphviz_language() -> None:
    facts = {
        'parent': 'a "world"',
        'broadcaster': 'me',
        'rate': 10.0,
        'most_recent_transform': 2.0,
        'oldest_transform': 1.0,
        'buffer_length': 1.0,
    }
    assert r'"a \"world\"" -> "base"[label=" Broadcaster: me\nAverage rate: 10.0\n' in draw(
        {'base': facts}, 3.0
    )


@pytest.fixture
def ros(isolated: dict[str, str]) -> Iterator[None]:
    with rclpy.init():
        yield


@pytest.mark.usefixtures('ros')
def test_a_buffer_answers_others(run: Run) -> None:
    run('tf2_ros', 'static_transform_publisher', '--z', '2', *FRAMES).expect('Spinning')
    run('tf2_ros', 'buffer_server')
    node = Node('asker')
    with Spinner(SingleThreadedExecutor(), node):
        client = BufferClient(node, 'tf2_buffer_server')
        assert client.action_client.wait_for_server(PATIENCE)
        found = client.lookup_transform('world', 'base', Time(), Duration(seconds=PATIENCE))
        assert found.transform.translation.z == 2.0
        with pytest.raises(TransformException, match='nobody'):
            client.lookup_transform('world', 'nobody', Time(), Duration(seconds=0.1))


@pytest.mark.usefixtures('ros')
def test_a_goal_of_the_buffer_is_cancelled_while_it_waits(run: Run) -> None:
    run('tf2_ros', 'buffer_server')
    node = Node('asker')
    with Spinner(SingleThreadedExecutor(), node):
        client = ActionClient(node, LookupTransform, 'tf2_buffer_server')
        assert client.wait_for_server(PATIENCE)
        goal = LookupTransform.Goal(target_frame='world', source_frame='base')
        goal.timeout.sec = 600
        goal_handle = result_of(client.send_goal_async(goal))
        result_of(goal_handle.cancel_goal_async())
        assert result_of(goal_handle.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_a_monitor_says_what_it_needs(run: Run) -> None:
    monitor = run('tf2_ros', 'tf2_monitor', 'world')
    assert monitor.wait() == 1
    assert 'it needs two frames, or none for all of them' in monitor.output
