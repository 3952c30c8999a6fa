"""Interfaces that tools of ROS 2 use: cmd_vel, trajectories, grippers, triggers, and the robot's topics."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator, Sequence

import pytest
from builtin_interfaces.msg import Duration, Time
from control_msgs.action import FollowJointTrajectory, GripperCommand
from control_msgs.msg import JointTolerance
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, WrenchStamped
from goalwire import GoalRefused
from goalwire.testing import Graph, VirtualClock
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from sensor_msgs.msg import BatteryState, Imu, JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.joints.service import JointStateService
from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.model import HOME, JOINT_BY_NAME, JOINTS
from humanoid.navigation.server import NavigationActionServer

pytestmark = pytest.mark.usefixtures('gw_clock')

LEFT = [name for name in JOINT_BY_NAME if name.startswith('left_arm_')]
ARM = 'left_arm_controller/follow_joint_trajectory'
HAND = 'left_gripper_controller/gripper_cmd'
Result = FollowJointTrajectory.Result


@pytest.fixture
def joints(gw_clock: VirtualClock, gw_graph: Graph) -> JointStateService:
    return gw_graph.start(JointStateService)


@pytest.fixture
def arms(joints: JointStateService, gw_graph: Graph) -> ArmActionServer:
    return gw_graph.start(ArmActionServer)


@pytest.fixture
def base(gw_clock: VirtualClock, gw_graph: Graph) -> NavigationActionServer:
    return gw_graph.start(NavigationActionServer)


def duration(seconds: float) -> Duration:
    return Duration(sec=int(seconds), nanosec=round((seconds - int(seconds)) * 1e9))


def trajectory(*points: tuple[float, float], names: Sequence[str] = LEFT) -> JointTrajectory:
    """Pairs of a time and the shoulder's angle; the other joints stay at home."""
    made = JointTrajectory(joint_names=list(names))
    for at, shoulder in points:
        angles = [shoulder if name == 'left_arm_shoulder' else HOME.get(name, 0.0) for name in names]
        made.points.append(JointTrajectoryPoint(positions=angles, time_from_start=duration(at)))
    return made


def follow(
    *points: tuple[float, float], names: Sequence[str] = LEFT, **fields: object
) -> FollowJointTrajectory.Goal:
    goal = FollowJointTrajectory.Goal(trajectory=trajectory(*points, names=names))
    for name, value in fields.items():
        setattr(goal, name, value)
    return goal


@pytest.mark.usefixtures('arms')
def test_an_arm_follows_a_trajectory(gw_graph: Graph, gw_clock: VirtualClock) -> None:
    outcome = gw_graph.send_goal(FollowJointTrajectory, ARM, follow((1.0, 1.2), (2.0, 0.8)))
    assert (outcome.result.error_code, outcome.result.error_string) == (
        Result.SUCCESSFUL,
        'Trajectory completed successfully',
    )
    shoulder = [feedback.actual.positions[LEFT.index('left_arm_shoulder')] for feedback in outcome.feedback]
    assert max(shoulder) == pytest.approx(1.2, abs=0.05)
    assert shoulder[-1] == pytest.approx(0.8, abs=0.05)
    assert all(max(map(abs, feedback.error.positions)) < 0.1 for feedback in outcome.feedback)
    assert len(outcome.feedback) == pytest.approx(40, abs=4)
    assert gw_clock.elapsed < 4.0


@pytest.mark.parametrize(
    ('goal', 'reason'),
    [
        (follow((1.0, 1.0), names=LEFT[:2]), 'it leaves out left_arm_shoulder_roll'),
        (
            follow((1.0, 1.0), names=[*LEFT[:-1], 'left_knee']),
            "'left_knee' is not a joint of this controller",
        ),
        (follow((1.0, 1.0), names=[*LEFT, LEFT[0]]), 'it names a joint twice'),
        (follow(), 'its trajectory has no points'),
        (follow((1.0, 9.0)), 'left_arm_shoulder cannot go to 9.0 rad'),
        (follow((2.0, 1.0), (1.0, 0.5)), 'time_from_start must be 0 or more and grow by point'),
        (follow((0.2, 2.5)), 'left_arm_shoulder would need 10.00 rad/s'),
        (follow((0.0, 1.0), (1.0, 1.5)), 'left_arm_shoulder would have to jump by 0.50 rad'),
        (follow((7200.0, 1.0)), 'it ends more than 3600 s from now'),
        (
            follow((1.0, 1.0), path_tolerance=[JointTolerance(name='tail', position=0.1)]),
            "a tolerance names 'tail'",
        ),
        (
            follow((1.0, 1.0), path_tolerance=[JointTolerance(name=LEFT[0], velocity=math.nan)]),
            'a tolerance of left_arm_shoulder is nan, not a number',
        ),
    ],
)
def test_a_trajectory_that_cannot_be_followed_is_refused(
    gw_graph: Graph, arms: ArmActionServer, capfd: pytest.CaptureFixture[str],
    goal: FollowJointTrajectory.Goal, reason: str,
) -> None:  # fmt: skip
    with pytest.raises(GoalRefused):
        gw_graph.send_goal(FollowJointTrajectory, ARM, goal)
    assert reason in capfd.readouterr().err


@pytest.mark.usefixtures('arms')
def test_a_trajectory_of_the_past_is_refused(gw_graph: Graph, capfd: pytest.CaptureFixture[str]) -> None:
    goal = follow((1.0, 1.0))
    goal.trajectory.header.stamp = Time(sec=int(time.time()) - 60)
    with pytest.raises(GoalRefused):
        gw_graph.send_goal(FollowJointTrajectory, ARM, goal)
    assert 'its stamp is old' in capfd.readouterr().err


@pytest.fixture
def robot(gw_clock: VirtualClock, joints: JointStateService) -> Iterator[Robot]:
    with Robot() as client:
        yield client


class Sender:
    """Goals of one action, on their way."""

    def __init__(self, robot: Robot, type_: type, name: str) -> None:
        self._client, self._name = ActionClient(robot.node, type_, name), name

    def __call__(self, goal: object) -> GoalRun:
        return GoalRun(self._client, self._name, goal, 60.0)


@pytest.fixture
def arm(robot: Robot, arms: ArmActionServer) -> Sender:
    return Sender(robot, FollowJointTrajectory, ARM)


@pytest.fixture
def hand(robot: Robot, arms: ArmActionServer) -> Sender:
    return Sender(robot, GripperCommand, HAND)


def grip(gap: float, effort: float = 0.0) -> GripperCommand.Goal:
    goal = GripperCommand.Goal()
    goal.command.position, goal.command.max_effort = gap, effort
    return goal


def push(graph: Graph, *points: tuple[float, float]) -> None:
    """Somebody else commands the shoulder, and the joints obey."""
    others = graph.publisher(JointTrajectory, 'joint_command')
    others.wait_for_subscriber()
    others.publish(trajectory(*points, names=['left_arm_shoulder']))


def test_a_joint_that_leaves_the_path_aborts_with_the_code(gw_graph: Graph, arm: Sender) -> None:
    with arm(
        follow((4.0, 2.5), path_tolerance=[JointTolerance(name='left_arm_shoulder', position=0.1)])
    ) as run:
        next(run.feedback())
        push(gw_graph, (1.0, -1.0))
        run.finish()
    assert (run.status, run.result.error_code) == ('ABORTED', Result.PATH_TOLERANCE_VIOLATED)
    assert 'off the path: left_arm_shoulder by' in run.result.error_string


def test_a_joint_that_does_not_arrive_aborts_with_the_code(gw_graph: Graph, arm: Sender) -> None:
    began = time.monotonic()
    with arm(follow((1.0, 1.0), goal_time_tolerance=duration(0.5))) as run:
        next(run.feedback())
        push(gw_graph, (1.0, 0.0))
        run.finish()
    assert (run.status, run.result.error_code) == ('ABORTED', Result.GOAL_TOLERANCE_VIOLATED)
    assert 'short of the goal: left_arm_shoulder by' in run.result.error_string
    assert time.monotonic() - began == pytest.approx(1.5, abs=0.3)  # virtual


def test_velocities_of_points_are_followed_on_a_cubic(gw_graph: Graph, arm: Sender) -> None:
    goal = follow((2.0, 1.5), path_tolerance=[JointTolerance(name='left_arm_shoulder', velocity=0.3)])
    for point in goal.trajectory.points:
        point.velocities = [0.0] * len(LEFT)
    with arm(goal) as run:
        feedback = list(run.feedback())
    assert run.result.error_code == Result.SUCCESSFUL, run.result.error_string
    shoulder = LEFT.index('left_arm_shoulder')
    assert max(each.desired.velocities[shoulder] for each in feedback) == pytest.approx(0.75, abs=0.01)
    assert max(each.actual.velocities[shoulder] for each in feedback) == pytest.approx(0.75, abs=0.02)
    assert max(abs(each.error.positions[shoulder]) for each in feedback) < 0.02, 'as of one moment'


def test_a_joint_that_is_too_fast_on_the_path_aborts_with_the_code(gw_graph: Graph, arm: Sender) -> None:
    with arm(
        follow((4.0, 1.5), path_tolerance=[JointTolerance(name='left_arm_shoulder', velocity=0.5)])
    ) as run:
        next(run.feedback())
        push(gw_graph, (1.0, -1.0))
        run.finish()
    assert (run.status, run.result.error_code) == ('ABORTED', Result.PATH_TOLERANCE_VIOLATED)
    assert re.search(r'off the path: left_arm_shoulder by [\d.]+ rad/s', run.result.error_string)


def test_a_goal_that_is_to_end_at_rest_waits_for_it(gw_graph: Graph, arm: Sender) -> None:
    tolerances = [JointTolerance(name='left_arm_shoulder', position=-1.0, velocity=0.1)]
    began = time.monotonic()
    with arm(follow((1.0, 1.0), goal_tolerance=tolerances, goal_time_tolerance=duration(5.0))) as run:
        next(run.feedback())
        push(gw_graph, (3.0, -1.0))
        run.finish()
    assert (run.status, run.result.error_code) == ('SUCCEEDED', Result.SUCCESSFUL)
    assert time.monotonic() - began > 2.9, 's, virtual: so long it was pushed'


def test_a_goal_tolerance_may_be_erased(gw_graph: Graph, arm: Sender) -> None:
    with arm(
        follow((1.0, 1.0), goal_tolerance=[JointTolerance(name='left_arm_shoulder', position=-1.0)])
    ) as run:
        next(run.feedback())
        push(gw_graph, (1.0, 0.0))
        run.finish()
    assert (run.status, run.result.error_code) == ('SUCCEEDED', Result.SUCCESSFUL)


def test_a_cancelled_trajectory_holds(robot: Robot, arm: Sender) -> None:
    with arm(follow((4.0, 2.5))) as run:
        next(run.feedback())
        run.cancel()
        run.finish()
    assert (run.status, run.result) == ('CANCELED', Result()), 'empty: error_code is SUCCESSFUL'
    time.sleep(0.2)  # virtual
    here = robot.joint('left_arm_shoulder')
    assert not here.is_moving
    assert here.position < 1.0


def test_a_newer_trajectory_takes_over(robot: Robot, arm: Sender) -> None:
    with arm(follow((4.0, 2.5))) as older:
        next(older.feedback())
        with arm(follow((1.0, 0.2))) as newer:
            older.finish()
            newer.finish()
    ended = (older.status, older.result.error_code, older.result.error_string)
    assert ended == ('ABORTED', Result.INVALID_GOAL, 'Pre-empted by a newer goal')
    assert newer.status == 'SUCCEEDED'
    assert robot.joint('left_arm_shoulder').position == pytest.approx(0.2, abs=0.02)


def test_joints_of_another_goal_are_refused_both_ways(robot: Robot, arm: Sender) -> None:
    with robot.reach({'left_arm_elbow': 1.0}, duration=2.0, timeout=20.0) as reach:
        with arm(follow((1.0, 1.0))) as refused:
            assert not refused.accepted
        reach.finish()
    with arm(follow((1.0, 1.0))) as run:
        with robot.reach({'left_arm_elbow': 1.0}, duration=2.0, timeout=20.0) as refused:
            assert not refused.accepted
        with robot.reach({'right_arm_elbow': 1.0}, duration=0.5, timeout=20.0) as other:
            other.finish()
        run.finish()
    assert (reach.status, other.status, run.status) == ('SUCCEEDED', 'SUCCEEDED', 'SUCCEEDED')


def test_a_hand_opens_closes_and_says_how_far(robot: Robot, hand: Sender) -> None:
    with hand(grip(0.06, effort=10.0)) as run:
        run.finish()
    assert (run.status, run.result.reached_goal, run.result.stalled) == ('SUCCEEDED', True, False)
    assert run.result.position == pytest.approx(0.06, abs=0.003)
    assert robot.joint('left_gripper').position == pytest.approx(0.03, abs=0.0015)


def test_a_hand_that_meets_something_has_gripped_it(gw_graph: Graph, hand: Sender) -> None:
    with hand(grip(0.08)) as run:
        run.finish()
    others = gw_graph.publisher(JointTrajectory, 'joint_command')
    others.wait_for_subscriber()
    with hand(grip(0.0)) as run:
        next(run.feedback())
        others.publish(JointTrajectory(joint_names=['left_gripper']))  # hold: as fingers at an object do
        run.finish()
    assert (run.status, run.result.reached_goal, run.result.stalled) == ('SUCCEEDED', False, True)
    assert run.result.position > 0.01


def test_a_cancelled_hand_holds_and_a_newer_goal_takes_over(robot: Robot, hand: Sender) -> None:
    with hand(grip(0.08)) as run:
        next(run.feedback())
        run.cancel()
        run.finish()
    assert (run.status, run.result) == ('CANCELED', GripperCommand.Result()), 'empty'
    time.sleep(0.2)  # virtual
    fingers = robot.joint('left_gripper')
    assert not fingers.is_moving
    assert fingers.position < 0.02
    with hand(grip(0.08)) as older:
        next(older.feedback())
        with hand(grip(0.02)) as newer:
            older.finish()
            newer.finish()
    assert (older.status, older.result.reached_goal, older.result.stalled) == ('ABORTED', False, False)
    assert (newer.status, newer.result.reached_goal) == ('SUCCEEDED', True)


@pytest.mark.parametrize('gap', [-0.01, 0.09, math.nan])
def test_a_gap_that_no_hand_has_is_refused(hand: Sender, gap: float) -> None:
    with hand(grip(gap)) as run:
        assert not run.accepted


@pytest.mark.usefixtures('arms')
def test_it_waves_and_then_stands(gw_graph: Graph, robot: Robot) -> None:
    raised: list[float] = []
    robot.node.create_subscription(
        JointState,
        'joint_states',
        lambda state: raised.append(state.position[state.name.index('right_arm_shoulder')]),
        50,
    )
    answer = gw_graph.call(Trigger, 'wave', timeout=60.0)
    assert (answer.success, answer.message) == (True, 'waved')
    assert min(raised) == pytest.approx(-2.4, abs=0.05)
    with robot.reach({'left_knee': 1.0, 'head_pan': 0.5}, duration=1.0, timeout=20.0) as run:
        run.finish()
    answer = gw_graph.call(Trigger, 'stand', timeout=60.0)
    assert (answer.success, answer.message) == (True, 'standing')
    for joint in JOINTS:
        assert robot.joint(joint.name).position == pytest.approx(joint.home, abs=joint.arrived_within)


def test_it_does_not_wave_with_an_arm_that_is_taken(
    gw_graph: Graph, robot: Robot, arms: ArmActionServer
) -> None:
    with robot.reach({'right_arm_elbow': 1.0}, duration=2.0, timeout=20.0) as run:
        answer = gw_graph.call(Trigger, 'wave', timeout=60.0)
        assert not answer.success
        assert 'right_arm_elbow is moving for another goal' in answer.message
        run.finish()


def twist(x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> Twist:
    command = Twist()
    command.linear.x, command.linear.y, command.angular.z = x, y, turn
    return command


def drive(graph: Graph, command: Twist, seconds: float) -> None:
    """Publish a velocity at 10 Hz for that long."""
    sender = graph.publisher(Twist, 'cmd_vel')
    sender.wait_for_subscriber()
    for _ in range(round(seconds * 10)):
        sender.publish(command)
        time.sleep(0.1)  # virtual
    sender.close()


def test_the_base_moves_by_cmd_vel_and_stops_half_a_second_after_the_last(
    gw_graph: Graph, base: NavigationActionServer
) -> None:
    drive(gw_graph, twist(x=0.5), 2.0)
    time.sleep(2.0)  # virtual
    assert base._base.pose.x == pytest.approx(0.5 * (1.9 + 0.5), abs=0.03)
    assert base._base.velocity.x == 0.0


def test_cmd_vel_turns_on_an_arc_and_is_bounded(gw_graph: Graph, base: NavigationActionServer) -> None:
    drive(gw_graph, twist(x=0.5, turn=0.5), 2.0)
    pose = base._base.pose
    assert pose.x == pytest.approx(math.sin(pose.yaw), abs=0.001)  # radius 1 m
    assert pose.y == pytest.approx(1.0 - math.cos(pose.yaw), abs=0.001)
    drive(gw_graph, twist(x=30.0, y=40.0, turn=99.0), 0.2)
    velocity = base._base.velocity
    assert math.hypot(velocity.x, velocity.y) == pytest.approx(0.8)
    assert velocity.y / velocity.x == pytest.approx(4 / 3)
    assert velocity.yaw == 1.5


def test_a_velocity_beyond_the_limits_is_reported_with_the_velocity_that_it_becomes(
    gw_graph: Graph, base: NavigationActionServer, capfd: pytest.CaptureFixture[str]
) -> None:
    drive(gw_graph, twist(x=0.8, turn=-1.5), 0.2)
    assert 'more than the base can do' not in capfd.readouterr().err
    drive(gw_graph, twist(x=-1.2, turn=2.0), 1.0)
    warned = re.findall(r'cmd_vel asks for more.*', capfd.readouterr().err)
    expected = (
        'cmd_vel asks for more than the base can do: -1.20 m/s ahead, 0.00 m/s to the left, 2.00 rad/s; '
        'it moves at -0.80 m/s ahead, 0.00 m/s to the left, 1.50 rad/s'
    )
    assert warned == [expected]


def test_a_velocity_that_is_no_number_is_ignored(gw_graph: Graph, base: NavigationActionServer) -> None:
    drive(gw_graph, twist(x=math.nan), 0.3)
    drive(gw_graph, twist(turn=math.inf), 0.3)
    assert base._base.pose.x == base._base.pose.yaw == 0.0


def test_cmd_vel_takes_over_from_a_goal_but_zeros_do_not(
    gw_graph: Graph, robot: Robot, base: NavigationActionServer
) -> None:
    with robot.drive(1.0, 0.0, allowed=20.0, timeout=30.0) as run:
        drive(gw_graph, twist(), 0.5)
        run.finish()
    assert run.status == 'SUCCEEDED'
    with robot.drive(9.0, 0.0, allowed=20.0, timeout=30.0) as run:
        next(run.feedback())
        drive(gw_graph, twist(x=-0.2), 0.5)
        run.finish()
    assert (run.status, run.result.message) == ('ABORTED', 'Pre-empted by cmd_vel')


def test_odometry_and_its_transform_agree(gw_graph: Graph, base: NavigationActionServer) -> None:
    odometry = gw_graph.record(Odometry, 'odom')
    transforms = gw_graph.record(TFMessage, '/tf')
    drive(gw_graph, twist(x=0.4, turn=0.3), 1.0)
    told = odometry.messages[-1]
    assert (told.header.frame_id, told.child_frame_id) == ('odom', 'base_link')
    assert told.pose.pose.position.z == pytest.approx(0.8)
    for covariance in (told.pose.covariance, told.twist.covariance):
        assert all(covariance[7 * axis] > 0.0 for axis in range(6))
    [same] = [
        each
        for message in transforms.messages
        for each in message.transforms
        if each.header.stamp == told.header.stamp
    ]
    assert (same.header.frame_id, same.child_frame_id) == ('odom', 'base_link')
    assert same.transform.translation.x == told.pose.pose.position.x
    assert same.transform.rotation == told.pose.pose.orientation


def test_the_imu_shows_gravity_turns_and_the_push_of_a_curve(
    gw_graph: Graph, base: NavigationActionServer
) -> None:
    imu = gw_graph.record(Imu, 'imu')
    drive(gw_graph, twist(x=0.4, turn=0.5), 0.5)
    told = imu.messages[-1]
    assert told.header.frame_id == 'imu_link'
    assert told.angular_velocity.z == 0.5
    assert told.linear_acceleration.x == pytest.approx(0.0)
    assert told.linear_acceleration.y == pytest.approx(0.2)
    assert told.linear_acceleration.z == pytest.approx(9.81, abs=0.01)
    assert told.orientation_covariance[8] > 0.0


def test_soles_carry_the_weight_where_they_touch_the_floor(
    gw_graph: Graph, robot: Robot, arms: ArmActionServer
) -> None:
    left = gw_graph.record(WrenchStamped, 'left_sole/wrench')
    right = gw_graph.record(WrenchStamped, 'right_sole/wrench')
    weight = 50.0 * 9.80665
    assert left.wait_for()[0].wrench.force.z == pytest.approx(weight / 2)
    with robot.reach({'left_knee': 1.0}, duration=1.0, timeout=20.0) as run:
        run.finish()
    assert left.messages[-1].wrench.force.z == 0.0
    assert right.messages[-1].wrench.force.z == pytest.approx(weight)
    assert right.messages[-1].header.frame_id == 'right_sole'


def test_the_battery_tells_itself_and_everybody_tells_how_he_is(
    gw_graph: Graph, arms: ArmActionServer, base: NavigationActionServer
) -> None:
    gw_graph.start(BatteryService)
    battery = gw_graph.record(BatteryState, 'battery_state')
    health = gw_graph.record(DiagnosticArray, '/diagnostics')
    assert 0.0 < battery.wait_for(2)[0].percentage <= 1.0
    time.sleep(2.0)  # virtual
    told = {status.name: status for array in health.messages for status in array.status}
    assert set(told) == {
        'joint_state_service: joints',
        'navigation_action_server: base',
        'arm_action_server: arms',
        'battery_service: battery',
    }
    assert {status.level for status in told.values()} == {b'\0'}
    assert told['navigation_action_server: base'].message == 'standing'
