"""The robot's servers over the wire, given every kind of number and text: each still works afterwards.

The tests share the servers.
"""

from __future__ import annotations

import math
import struct
import sys
from collections.abc import Iterator, Mapping, Sequence

import pytest
from geometry_msgs.msg import Point, Quaternion
from helpers.collector import Collector
from helpers.processes import Program
from helpers.robot import humanoid, robot_client
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetJointState
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.mission.calls import GoalRun, call
from humanoid.mission.robot import Robot
from humanoid.model import JOINTS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

WITHIN = 20.0
LOG_LIMIT = 20_000  # characters: of one refusal or warning, whatever was sent
SHOULDER, ELBOW = 'left_arm_shoulder', 'left_arm_elbow'
HUGE_NAME = 'j' * 10_000_000


def _double(bits: int) -> float:
    number: float = struct.unpack('<d', struct.pack('<Q', bits))[0]
    return number


SPECIAL = [
    0.0,
    -0.0,
    math.nan,
    _double(0xFFF8_0000_0000_0001),  # a NaN with sign and payload
    _double(0x7FF0_0000_0000_0001),  # a signalling one
    math.inf,
    -math.inf,
    sys.float_info.max,
    -sys.float_info.max,
    sys.float_info.min,
    -sys.float_info.min,
    _double(1),  # the smallest subnormal
    -_double(1),
    _double(0x000F_FFFF_FFFF_FFFF),  # the greatest subnormal
    2.0**31 - 1,
    2.0**31,
    -(2.0**31) - 1,
    2.0**32,
    2.0**53,
    2.0**63,
    2.0**64,
    3e9,
]
POWERS = [sign * float(f'1e{power}') for power in range(-323, 309) for sign in (1.0, -1.0)]
EVERY_TENTH = [sign * float(f'1e{power}') for power in range(-320, 309, 10) for sign in (1.0, -1.0)]

TEXTS = st.text(st.characters(exclude_characters='\0', exclude_categories=['Cs']))  # what a string may hold


@pytest.fixture
def robot(shared_world: dict[str, str]) -> Iterator[Robot]:
    with robot_client() as client:
        yield client


@pytest.fixture(scope='module')
def joints(shared_world: dict[str, str]) -> Iterator[Program]:
    with humanoid('joint_state_service', env=shared_world) as program:
        program.expect('Joint State Service ready')
        yield program


@pytest.fixture(scope='module')
def arm(shared_world: dict[str, str], joints: Program) -> Iterator[Program]:
    with humanoid('arm_action_server', env=shared_world) as program:
        program.expect('Arm Action Server ready')
        yield program


@pytest.fixture(scope='module')
def base(shared_world: dict[str, str]) -> Iterator[Program]:
    with humanoid('navigation_action_server', env=shared_world) as program:
        program.expect('Navigation Action Server ready')
        yield program


@pytest.fixture(scope='module')
def battery(shared_world: dict[str, str]) -> Iterator[Program]:
    with humanoid('battery_service', env=shared_world) as program:
        program.expect('Battery Service ready')
        yield program


def try_reach(robot: Robot, joints: Mapping[str, float], duration: float) -> bool:
    """Send an arm goal and cancel it at once; True if it was accepted, and then it has ended.

    A goal that is cancelled leaves the joints anywhere, so that every goal after it may take its whole time.
    """
    with robot.reach(joints, duration=duration, timeout=WITHIN) as run:
        if run.accepted:
            run.cancel()
        run.finish()
    return run.accepted


def assert_the_arm_works(server: Program, robot: Robot) -> None:
    for target in (0.3, 0.0):
        with robot.reach({ELBOW: target}, duration=0.5, timeout=WITHIN) as run:
            run.finish()
        assert (run.status, run.result.success) == ('SUCCEEDED', True)
    assert 'Traceback' not in server.output


def test_the_arm_outlives_every_duration(arm: Program, robot: Robot) -> None:
    """The elbow stays at 0 rad: each goal that is accepted has been reached before it begins."""
    for duration in SPECIAL + POWERS:
        with robot.reach({ELBOW: 0.0}, duration=duration, timeout=WITHIN) as run:
            run.finish()
        assert run.accepted == (0.01 <= duration <= 3600.0), duration
    assert_the_arm_works(arm, robot)


def test_the_arm_outlives_every_position(arm: Program, robot: Robot) -> None:
    for position in sorted(SPECIAL + EVERY_TENTH, key=abs):
        assert try_reach(robot, {ELBOW: position}, 2.0) == (0.0 <= position <= 2.4), position
    assert_the_arm_works(arm, robot)


def test_the_arm_outlives_any_numbers(arm: Program, robot: Robot) -> None:
    @settings(max_examples=200, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.floats(), st.floats())
    def outlives(position: float, duration: float) -> None:
        try_reach(robot, {ELBOW: position}, duration)

    outlives()
    assert_the_arm_works(arm, robot)


@pytest.mark.parametrize(
    ('names', 'positions', 'reason'),
    [
        ([HUGE_NAME], [0.0], r'unknown joint .*10000000 characters'),
        ([f'joint_{number}' for number in range(100_000)], [0.0] * 100_000, 'unknown joint'),
        ([ELBOW] * 100_000, [0.0] * 100_000, 'named twice'),
        ([ELBOW], [0.0] * 1_000_000, '1000000 positions for 1 joints'),
        (['\x1b[2J\n[INFO] forged'], [0.0], r"unknown joint '\\x1b\[2J\\n\[INFO\] forged'"),
        (['elbow', ''], [0.0, 0.0], 'unknown joint'),
    ],
    ids=['10 MB', '100,000 names', 'one name 100,000 times', '1,000,000 positions', 'escapes', 'empty'],
)
def test_the_arm_refuses_any_names_in_one_bounded_line(
    arm: Program, robot: Robot, names: Sequence[str], positions: Sequence[float], reason: str
) -> None:
    before = len(arm.output)
    client = ActionClient(robot.node, MoveArm, 'move_arm')
    goal = MoveArm.Goal(joint_names=list(names), positions=list(positions), duration=1.0)
    assert not GoalRun(client, 'move_arm', goal, WITHIN).accepted
    client.destroy()
    arm.expect(f'Rejected: .*{reason}')
    assert len(arm.output) - before < LOG_LIMIT
    assert_the_arm_works(arm, robot)


def hostile_states() -> Iterator[JointState]:
    names = [joint.name for joint in JOINTS]
    for number in SPECIAL:
        yield JointState(name=names, position=[number] * len(names), velocity=[number] * len(names))
    yield JointState(name=[SHOULDER], position=[0.5])
    yield JointState(name=names)
    yield JointState(name=[HUGE_NAME], position=[0.0], velocity=[1.0])
    yield JointState(name=[f'joint_{number}' for number in range(100_000)], position=[0.0] * 100_000)
    late = JointState(name=names, position=[joint.home for joint in JOINTS])
    late.header.stamp.sec, late.header.stamp.nanosec = 2**31 - 1, 2**32 - 1
    yield late


def test_the_arm_outlives_any_joint_states_while_it_moves(arm: Program, robot: Robot) -> None:
    states = robot.node.create_publisher(JointState, 'joint_states', 10)
    with robot.reach({SHOULDER: 1.5}, duration=3.0, timeout=WITHIN) as run:
        next(run.feedback())
        for state in hostile_states():
            states.publish(state)
        run.finish()  # how it ends depends on what it was shown last
    robot.node.destroy_publisher(states)
    assert_the_arm_works(arm, robot)


def drive_goal(field: str, number: float) -> MoveToPosition.Goal:
    """A sound goal that ends at once, but for one number."""
    goal = MoveToPosition.Goal(timeout=0.1)
    goal.target_pose.pose.orientation = Quaternion(w=1.0)
    if field == 'timeout':
        goal.timeout = number
    elif field.startswith('turn_'):
        setattr(goal.target_pose.pose.orientation, field[-1], number)
    else:
        setattr(goal.target_pose.pose.position, field, number)
    return goal


@pytest.mark.parametrize('field', ['x', 'y', 'z', 'turn_x', 'turn_y', 'turn_z', 'turn_w', 'timeout'])
def test_the_base_outlives_every_number(base: Program, robot: Robot, field: str) -> None:
    client = ActionClient(robot.node, MoveToPosition, 'move_to_position')
    odometry: Collector[Odometry] = Collector()
    runs = []
    for number in SPECIAL + EVERY_TENTH:
        run = GoalRun(client, 'move_to_position', drive_goal(field, number), WITHIN)
        assert not (run.accepted and not math.isfinite(number)), number
        runs.append(run)
    for run in runs:
        run.finish()
    with robot.drive(0.2, 0.1, allowed=WITHIN, timeout=WITHIN + 1.0) as last:
        last.finish()
    client.destroy()
    assert last.status == 'SUCCEEDED', last.result.message
    robot.node.create_subscription(Odometry, 'odom', odometry, 10)
    pose = odometry.expect(1)[0].pose.pose
    assert (pose.position.x, pose.position.y) == (0.2, 0.1)
    assert not math.isnan(pose.orientation.w)
    assert 'Traceback' not in base.output


def test_the_base_outlives_any_pose(base: Program, robot: Robot) -> None:
    client = ActionClient(robot.node, MoveToPosition, 'move_to_position')

    @settings(max_examples=200, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.tuples(*[st.floats()] * 3), st.tuples(*[st.floats()] * 4), st.floats(), TEXTS)
    def outlives(where: tuple[float, ...], turn: tuple[float, ...], allowed: float, frame: str) -> None:
        goal = MoveToPosition.Goal(timeout=allowed)
        goal.target_pose.header.frame_id = frame if len(frame) > 3 else ''
        goal.target_pose.pose.position = Point(x=where[0], y=where[1], z=where[2])
        goal.target_pose.pose.orientation = Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3])
        with GoalRun(client, 'move_to_position', goal, WITHIN):
            pass

    outlives()
    client.destroy()
    with robot.drive(0.2, 0.0, allowed=10.0, timeout=WITHIN) as run:
        run.finish()
    assert run.status == 'SUCCEEDED'
    assert 'Traceback' not in base.output


def test_the_base_refuses_a_frame_of_10_mb_in_one_bounded_line(base: Program, robot: Robot) -> None:
    before = len(base.output)
    client = ActionClient(robot.node, MoveToPosition, 'move_to_position')
    goal = drive_goal('x', 0.0)
    goal.target_pose.header.frame_id = HUGE_NAME
    goal.target_pose.header.stamp.sec = -(2**31)
    assert not GoalRun(client, 'move_to_position', goal, WITHIN).accepted
    client.destroy()
    base.expect('Rejected: frame_id')
    assert len(base.output) - before < LOG_LIMIT


def test_the_joints_outlive_any_command_and_any_question(world: dict[str, str]) -> None:
    """Alone in a world: an arm's server would command its joints, too."""
    with humanoid('joint_state_service', env=world) as joints, robot_client() as robot:
        joints.expect('Joint State Service ready')
        commands = robot.node.create_publisher(JointTrajectory, 'joint_command', 10)
        assert robot.joint(ELBOW).position == 0.0
        for number in SPECIAL:
            commands.publish(JointTrajectory(points=[JointTrajectoryPoint(positions=[number] * len(JOINTS))]))
        for sec in (-(2**31), -1, 2**31 - 1):
            command = JointTrajectory(joint_names=[ELBOW], points=[JointTrajectoryPoint(positions=[0.0])])
            command.header.stamp.sec = command.points[0].time_from_start.sec = sec
            command.header.stamp.nanosec = command.points[0].time_from_start.nanosec = 2**32 - 1
            commands.publish(command)
        commands.publish(JointTrajectory(joint_names=[HUGE_NAME]))
        commands.publish(JointTrajectory(points=[JointTrajectoryPoint() for _ in range(50_000)]))
        joints.expect('Ignored a joint command: 50000 points are more than 1000')
        client = robot.node.create_client(GetJointState, 'get_joint_state')
        for name in (HUGE_NAME, '', '\x1b[2J'):
            assert call(client, GetJointState.Request(joint_name=name), WITHIN).position == 0.0
        assert len(joints.output) < 2 * LOG_LIMIT
        commands.publish(JointTrajectory(joint_names=[ELBOW], points=[JointTrajectoryPoint(positions=[0.3])]))
        while (
            robot.joint(ELBOW).position < 0.3
        ):  # bounded by the test's time limit; each call is a round trip
            pass
        assert 'Traceback' not in joints.output


def test_the_battery_outlives_any_speed(battery: Program, robot: Robot) -> None:
    odometry = robot.node.create_publisher(Odometry, 'odom', 10)
    states = robot.node.create_publisher(JointState, 'joint_states', 10)
    robot.battery(WITHIN)
    for number in SPECIAL:
        message = Odometry()
        message.twist.twist.linear.x = message.twist.twist.linear.y = number
        odometry.publish(message)
        status = robot.battery(WITHIN)
        assert 0.7 < status.battery.percentage <= 1.0, number
        assert abs(status.battery.current) < 1e5, number
    for state in hostile_states():
        states.publish(state)
        assert 0.7 < robot.battery(WITHIN).battery.percentage <= 1.0
    assert 'Traceback' not in battery.output
