"""joint_state_service as its own process, asked and watched from this one."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from statistics import median

import pytest
from helpers.collector import Collector
from helpers.processes import Program
from helpers.robot import humanoid
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.mission.robot import Robot

pytestmark = pytest.mark.slow


@pytest.fixture
def server(world: dict[str, str]) -> Iterator[Program]:
    with humanoid('joint_state_service', env=world) as program:
        program.expect('Joint State Service ready')
        yield program


@pytest.fixture
def states(robot: Robot) -> Collector[JointState]:
    seen: Collector[JointState] = Collector()
    robot.node.create_subscription(JointState, 'joint_states', seen, 100)
    return seen


def position(state: JointState, name: str) -> float:
    return float(state.position[state.name.index(name)])


@pytest.mark.parametrize(
    ('joint', 'expected'),
    [('left_arm_shoulder', 0.5), ('right_arm_shoulder', -0.5), ('left_knee', 0.0), ('right_knee', 0.0)],
)
def test_it_answers_as_in_the_chapter(server: Program, robot: Robot, joint: str, expected: float) -> None:
    state = robot.joint(joint)
    assert (state.position, state.velocity, state.effort, state.is_moving) == (expected, 0.0, 0.0, False)
    server.expect(f'Served joint state for: {joint}')


def test_an_unknown_joint_is_a_warning_and_zeros(server: Program, robot: Robot) -> None:
    state = robot.joint('tail')
    assert (state.position, state.velocity, state.effort, state.is_moving) == (0.0, 0.0, 0.0, False)
    assert 'WARN' in server.expect('Unknown joint: tail').string


def test_joint_states_come_at_fifty_hertz(server: Program, states: Collector[JointState]) -> None:
    came = states.expect(51)
    stamps = [state.header.stamp.sec + state.header.stamp.nanosec / 1e9 for state in came[:51]]
    periods = [later - earlier for earlier, later in pairwise(stamps)]
    assert median(periods) == pytest.approx(0.02, rel=0.1)  # a busy machine leaves out some
    assert list(came[0].name[:2]) == ['left_arm_shoulder', 'left_arm_elbow']
    assert len(came[0].name) == len(came[0].position) == len(came[0].velocity) == len(came[0].effort)


def test_a_joint_command_moves_the_joints_and_everybody_sees_it(
    server: Program, robot: Robot, states: Collector[JointState]
) -> None:
    commands = robot.node.create_publisher(JointTrajectory, 'joint_command', 10)
    point = JointTrajectoryPoint(positions=[1.0])
    point.time_from_start.nanosec = 400_000_000
    states.expect(1)  # so that the two processes have met
    commands.publish(JointTrajectory(joint_names=['left_knee'], points=[point]))
    came = states.expect(60)
    assert any(abs(velocity) > 1.0 for state in came for velocity in state.velocity)
    assert position(came[-1], 'left_knee') == pytest.approx(1.0)
    assert position(came[-1], 'right_knee') == 0.0


def test_an_impossible_joint_command_is_ignored_with_a_reason(
    server: Program, robot: Robot, states: Collector[JointState]
) -> None:
    commands = robot.node.create_publisher(JointTrajectory, 'joint_command', 10)
    point = JointTrajectoryPoint(positions=[9.0])
    point.time_from_start.sec = 1
    states.expect(1)  # so that the two processes have met
    commands.publish(JointTrajectory(joint_names=['left_knee'], points=[point]))
    server.expect('Ignored a joint command: left_knee cannot go to 9.0 rad')
    assert robot.joint('left_knee').position == 0.0


def test_client_first_server_second(world: dict[str, str], robot: Robot) -> None:
    with humanoid('joint_state_service', env=world):
        assert robot.joint('left_arm_shoulder', timeout=15.0).position == 0.5
