"""robot_state_publisher: topics, rules and parameters of ROS 2's own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest
from apps.programs.conftest import Run
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from goalwire import DurabilityPolicy, QoS
from goalwire.apps.programs.robot_state_publisher import RobotStatePublisher
from goalwire.testing import Graph, VirtualClock
from goalwire.testing.topics import Publisher, Recorder

LATCHED = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TINY = """
<robot name="tiny"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="lead" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
<limit lower="0" upper="9" velocity="1" effort="1"/><mimic joint="lead" multiplier="2" offset="1"/></joint>
<joint name="still" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0 0 0.5"/></joint></robot>
"""
OTHER = '<robot name="other"><link name="x"/><link name="y"/>{}</robot>'
FIXED = '<joint name="j" type="fixed"><parent link="x"/><child link="y"/></joint>'


class Bench:
    """A publisher of transforms, given joint states and listened to."""

    def __init__(self, graph: Graph, text: str, **parameters: str | float) -> None:
        self.graph = graph
        self.moving: Recorder[TFMessage] = graph.record(TFMessage, '/tf')
        given = [Parameter(name, value=value) for name, value in parameters.items()]
        self.node = graph.start(lambda: RobotStatePublisher(text, parameter_overrides=given))
        self.fixed: Recorder[TFMessage] = graph.record(TFMessage, '/tf_static', qos=LATCHED)
        self.description: Recorder[String] = graph.record(String, 'robot_description', qos=LATCHED)
        self.states: Publisher[JointState] = graph.publisher(JointState, 'joint_states')
        self.states.wait_for_subscriber()

    def move(self, *, at: float = 1.0, **positions: float) -> None:
        message = JointState(name=list(positions), position=list(positions.values()))
        message.header.stamp = Time(sec=int(at), nanosec=round((at - int(at)) * 1e9))
        self.states.publish(message)

    def set(self, name: str, value: str | float) -> tuple[bool, str]:
        parameter: ParameterMsg = Parameter(name, value=value).to_parameter_msg()
        result = self.graph.call(
            SetParametersAtomically,
            '/robot_state_publisher/set_parameters_atomically',
            parameters=[parameter],
        ).result
        return result.successful, result.reason

    def frames(self, recorder: Recorder[TFMessage]) -> list[tuple[str, str]]:
        """Parents and children of the last message."""
        return [(each.header.frame_id, each.child_frame_id) for each in recorder.messages[-1].transforms]


@pytest.fixture
def bench(gw_clock: VirtualClock, gw_graph: Graph) -> Callable[..., Bench]:
    return lambda text=TINY, **parameters: Bench(gw_graph, text, **parameters)


def test_the_description_is_latched_and_fixed_links_are_told_once(bench: Callable[..., Bench]) -> None:
    tested = bench()
    assert tested.description.wait_for()[0].data == TINY
    tested.fixed.wait_for()
    assert tested.frames(tested.fixed) == [('c', 'd')]


def test_a_mimic_moves_with_its_leader(bench: Callable[..., Bench]) -> None:
    tested = bench()
    tested.move(at=7.25, lead=1.0)
    message = tested.moving.wait_for()[0]
    assert tested.frames(tested.moving) == [('a', 'b'), ('b', 'c')]
    assert message.transforms[1].transform.translation.x == 3.0
    assert message.transforms[0].header.stamp == Time(sec=7, nanosec=250_000_000)


def test_a_joint_is_published_no_more_often_than_publish_frequency(
    bench: Callable[..., Bench], gw_clock: VirtualClock
) -> None:
    tested = bench(publish_frequency=10.0)
    for tick in range(51):
        tested.move(at=1.0 + tick / 50.0, lead=0.0)
        time.sleep(0.02)  # virtual
    tested.move(at=9.0, lead=0.5)
    came = tested.moving.messages.wait_until(
        lambda seen: bool(seen) and seen[-1].transforms[0].header.stamp.sec == 9
    )
    assert len(came) == 12


def test_two_states_of_one_moment_are_one_unless_timestamps_are_ignored(bench: Callable[..., Bench]) -> None:
    tested = bench()
    tested.move(lead=0.1)
    tested.move(lead=0.2)
    tested.move(at=2.0, lead=0.3)
    assert len(tested.moving.wait_for(2)) == 2
    assert tested.set('ignore_timestamp', value=True) == (True, '')
    tested.move(at=2.0, lead=0.4)
    tested.move(at=1.0, lead=0.5)
    assert len(tested.moving.wait_for(4)) == 4


def test_frames_have_the_prefix_and_a_new_one_is_told(bench: Callable[..., Bench]) -> None:
    tested = bench(frame_prefix='alice/')
    tested.fixed.wait_for()
    assert tested.frames(tested.fixed) == [('alice/c', 'alice/d')]
    tested.move(lead=0.1)
    tested.moving.wait_for()
    assert tested.frames(tested.moving)[0] == ('alice/a', 'alice/b')
    assert tested.set('frame_prefix', 'bob/')[0]
    tested.fixed.messages.wait_until(lambda _: tested.frames(tested.fixed)[-1] == ('bob/c', 'bob/d'))


def test_a_new_description_is_checked_and_then_told(bench: Callable[..., Bench]) -> None:
    tested = bench()
    ok, reason = tested.set('robot_description', OTHER.format(''))
    assert (ok, reason) == (False, 'robot_description: it has 2 root links, and needs one: x, y')
    assert not tested.set('robot_description', ' ')[0]
    assert not tested.set('robot_description', 5)[0]
    assert not tested.set('publish_frequency', -1.0)[0]
    new = OTHER.format(FIXED)
    assert tested.set('robot_description', new) == (True, '')
    assert tested.description.messages.wait_until(lambda seen: seen[-1].data == new)
    tested.fixed.messages.wait_until(lambda _: ('x', 'y') in tested.frames(tested.fixed))


@pytest.mark.parametrize(
    'state',
    [
        JointState(name=['lead']),
        JointState(name=['lead'], position=[0.0, 1.0]),
        JointState(name=['tail'], position=[1.0]),
        JointState(name=['lead'], position=[float('nan')]),
    ],
)
def test_a_state_that_cannot_be_drawn_is_passed_over(bench: Callable[..., Bench], state: JointState) -> None:
    tested = bench()
    tested.states.publish(state)
    tested.move(lead=0.25)
    assert tested.moving.wait_for()[0].transforms[0].header.stamp.sec == 1
    assert len(tested.moving.messages) == 1


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        ([], 'the parameter robot_description: the URDF is empty'),
        (['/nowhere.urdf'], '/nowhere.urdf cannot be read'),
        (
            ['--ros-args', '-p', 'robot_description:=<robot/>'],
            'robot_description: it has 0 links',
        ),
        (['--ros-args', '-p', 'publish_frequency:=.nan'], 'publish_frequency'),
    ],
)
def test_it_says_in_a_line_why_it_cannot_begin(run: Run, arguments: list[str], complaint: str) -> None:
    program = run('robot_state_publisher', 'robot_state_publisher', *arguments)
    assert program.wait() == 1
    assert 'Traceback' not in program.output
    assert complaint in program.output.splitlines()[-1]


def test_the_file_of_a_urdf_is_taken_and_becomes_the_parameter(run: Run, tmp_path: Path) -> None:
    (tmp_path / 'tiny.urdf').write_text(TINY)
    run('robot_state_publisher', 'robot_state_publisher', 'tiny.urdf').expect('Robot initialized')
    echo = run('tf2_ros', 'tf2_echo', 'c', 'd', '20')
    echo.expect(r'- Translation: \[0.000, 0.000, 0.500\]')
