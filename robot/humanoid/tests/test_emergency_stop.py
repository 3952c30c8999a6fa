"""The emergency stop: all goals end, every command is refused, until it is released."""

from __future__ import annotations

import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial

import pytest
from control_msgs.action import FollowJointTrajectory, GripperCommand
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from goalwire import QoS
from goalwire.testing import Graph, VirtualClock
from helpers.collector import Collector
from helpers.patience import wait_for
from helpers.robot import humanoid, on_both_wires, robot_client
from helpers.wires import DDS, require
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.arm.server import ArmActionServer
from humanoid.emergency.votes import GONE
from humanoid.joints.service import JointStateService
from humanoid.mission.calls import GoalRun, call
from humanoid.mission.robot import Robot
from humanoid.model import HOME, JOINT_BY_NAME
from humanoid.navigation.server import NavigationActionServer

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LEFT = [name for name in JOINT_BY_NAME if name.startswith('left_arm_')]
TAKEN = (*LEFT, 'left_gripper', 'right_knee')  # by the trajectory, the quick goal and the flood
SLOWLY = 60  # s that each of the motions would take


@pytest.fixture
def robot(gw_clock: VirtualClock, gw_graph: Graph) -> Iterator[Robot]:
    for server in (JointStateService, NavigationActionServer, ArmActionServer):
        gw_graph.start(server)
    with Robot() as client:
        yield client


def slow_trajectory() -> FollowJointTrajectory.Goal:
    goal = FollowJointTrajectory.Goal()
    angles = [2.5 if name == 'left_arm_shoulder' else HOME.get(name, 0.0) for name in LEFT]
    point = JointTrajectoryPoint(positions=angles)
    point.time_from_start.sec = SLOWLY
    goal.trajectory.joint_names, goal.trajectory.points = LEFT, [point]
    return goal


class Everything:
    """A goal of every kind, each on joints of its own."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        arm, hand = 'left_arm_controller/follow_joint_trajectory', 'left_gripper_controller/gripper_cmd'
        self._arm = ActionClient(robot.node, FollowJointTrajectory, arm), arm
        self._hand = ActionClient(robot.node, GripperCommand, hand), hand

    def goals(self) -> list[GoalRun]:
        """A drive, a trajectory of one arm, and a goal for each joint of the others."""
        others = {name: joint.upper / 2 for name, joint in JOINT_BY_NAME.items() if name not in TAKEN}
        return [
            self._robot.drive(9.0, 9.0, allowed=50.0, timeout=60.0),
            GoalRun(*self._arm, slow_trajectory(), 70.0),
            *(
                self._robot.reach({name: angle}, duration=float(SLOWLY), timeout=70.0)
                for name, angle in others.items()
            ),
        ]

    def quick(self) -> GoalRun:
        goal = GripperCommand.Goal()
        goal.command.position = 0.02
        return GoalRun(*self._hand, goal, 20.0)


def throw(robot: Robot, *, stopped: bool) -> str:
    client = robot.node.create_client(SetBool, 'emergency_stop')
    answer = call(client, SetBool.Request(data=stopped), 20.0)
    assert answer.success
    return str(answer.message)


def test_goals_of_every_kind_are_aborted_and_refused_until_it_is_released(
    gw_graph: Graph, robot: Robot
) -> None:
    everything = Everything(robot)
    runs = everything.goals()
    assert len(runs) == 24
    assert all(run.accepted for run in runs)
    assert throw(robot, stopped=True) == 'stopped: /mission called the service'
    for run in runs:
        run.finish()
        assert run.status == 'ABORTED'
    assert {getattr(run.result, 'message', '') or run.result.error_string for run in runs} == {
        'Emergency stop'
    }
    assert not any(run.accepted for run in (*everything.goals(), everything.quick()))
    for gesture in ('wave', 'stand'):
        answer = gw_graph.call(Trigger, gesture)
        assert not answer.success
        assert answer.message == 'emergency stop: nothing moves until emergency_stop is called with false'
    assert throw(robot, stopped=False) == 'released'
    with everything.quick() as run:
        run.finish()
    assert run.status == 'SUCCEEDED'
    assert gw_graph.call(Trigger, 'stand', timeout=60.0).success


def test_joints_and_base_stand_and_obey_no_command(gw_graph: Graph, robot: Robot) -> None:
    odometry = gw_graph.record(Odometry, 'odom')
    commands = gw_graph.publisher(JointTrajectory, 'joint_command')
    velocities = gw_graph.publisher(Twist, 'cmd_vel')
    commands.wait_for_subscriber()
    velocities.wait_for_subscriber()

    def disturb() -> None:
        point = JointTrajectoryPoint(positions=[1.5])
        point.time_from_start.sec = 1
        commands.publish(JointTrajectory(joint_names=['left_knee'], points=[point]))
        command = Twist()
        command.linear.x = 0.5
        velocities.publish(command)

    disturb()
    time.sleep(0.3)  # virtual
    assert robot.joint('left_knee').is_moving
    assert odometry.messages[-1].twist.twist.linear.x == 0.5
    throw(robot, stopped=True)
    time.sleep(0.1)
    stood = robot.joint('left_knee').position
    disturb()
    time.sleep(1.0)
    assert robot.joint('left_knee').position == stood
    assert odometry.messages[-1].twist.twist.linear.x == 0.0
    throw(robot, stopped=False)
    time.sleep(1.0)
    assert robot.joint('left_knee').position == stood, 'what was refused is not made up for'
    disturb()
    time.sleep(1.2)
    assert robot.joint('left_knee').position == pytest.approx(1.5)


def test_a_button_stops_and_only_the_service_releases(gw_graph: Graph, robot: Robot) -> None:
    state = gw_graph.record(
        Bool, 'emergency_stopped', qos=QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    button = gw_graph.publisher(Bool, 'emergency_stop')
    button.wait_for_subscriber()
    assert state.wait_for()[0].data is False
    button.publish(data=True)
    time.sleep(0.5)  # virtual
    assert state.messages[-1].data is True
    button.publish(data=False)
    time.sleep(0.5)  # virtual
    assert state.messages[-1].data is True
    with robot.drive(1.0, 0.0, allowed=10.0, timeout=20.0) as run:
        assert not run.accepted
    throw(robot, stopped=False)
    time.sleep(0.5)  # virtual
    assert state.messages[-1].data is False


def test_the_status_says_why_the_robot_is_stopped_and_by_whom(gw_graph: Graph, robot: Robot) -> None:
    latched = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    status = gw_graph.record(DiagnosticStatus, 'emergency_stop_status', qos=latched)

    def told(count: int) -> tuple[bytes, str, dict[str, str]]:
        last = status.wait_for(count)[-1]
        return last.level, last.message, {each.key: each.value for each in last.values}

    assert told(1) == (DiagnosticStatus.OK, 'released', {'stopped': 'false', 'by': ''})
    assert throw(robot, stopped=True) == 'stopped: /mission called the service'
    reason = '/mission called the service'
    assert told(2) == (DiagnosticStatus.ERROR, reason, {'stopped': 'true', 'by': '/mission'})
    assert throw(robot, stopped=True) == f'stopped: {reason}', 'the first reason stays'
    throw(robot, stopped=False)
    assert told(3) == (DiagnosticStatus.OK, 'released', {'stopped': 'false', 'by': ''})
    late = gw_graph.record(DiagnosticStatus, 'emergency_stop_status', qos=latched)
    assert late.wait_for()[0].message == 'released'


def test_a_server_that_comes_late_knows_that_it_is_stopped(gw_graph: Graph, gw_clock: VirtualClock) -> None:
    gw_graph.start(JointStateService)
    with Robot() as robot:
        throw(robot, stopped=True)
        gw_graph.start(NavigationActionServer)
        time.sleep(0.5)  # virtual
        with robot.drive(1.0, 0.0, allowed=10.0, timeout=20.0) as run:
            assert not run.accepted


def test_a_switch_that_is_gone_stops_the_robot_and_its_next_one_is_to_be_released(
    gw_clock: VirtualClock, gw_graph: Graph
) -> None:
    switch = gw_graph.start(JointStateService)
    gw_graph.start(NavigationActionServer)
    with Robot() as robot:
        with robot.drive(9.0, 9.0, allowed=50.0, timeout=60.0) as run:
            for _ in zip(range(20), run.feedback(), strict=False):  # 2 s, virtual
                pass
            began = time.monotonic()
            switch.destroy_node()
            run.finish()
        assert (run.status, run.result.message) == ('ABORTED', f'Emergency stop: {GONE}')
        assert 0.8 < time.monotonic() - began < 1.5, 's, virtual'
        assert not accepted(robot)
        gw_graph.start(JointStateService)
        time.sleep(1.0)  # virtual
        assert not accepted(robot), 'it is back, and thrown'
        assert throw(robot, stopped=False) == 'released'
        assert accepted(robot)


@pytest.fixture
def stranger(robot: Robot) -> Iterator[Node]:
    """A node that does not belong to the robot, beside a robot that has said how it stands."""
    assert accepted(robot)
    node = Node('stranger')
    yield node
    node.destroy_node()


def says(stranger: Node) -> Callable[[bool], None]:
    """Return what publishes on `emergency_stopped`, once all three servers hear it."""
    publisher = stranger.create_publisher(Bool, 'emergency_stopped', 1)
    while publisher.get_subscription_count() < 3:
        time.sleep(0.1)  # virtual
    return lambda stopped: publisher.publish(Bool(data=stopped))


def test_a_stranger_stops_the_robot_and_cannot_release_it(
    gw_graph: Graph, robot: Robot, stranger: Node
) -> None:
    latched = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    status = gw_graph.record(DiagnosticStatus, 'emergency_stop_status', qos=latched)
    commands = gw_graph.publisher(JointTrajectory, 'joint_command')
    commands.wait_for_subscriber()
    say = says(stranger)
    throw(robot, stopped=True)
    say(False)
    time.sleep(1.5)  # virtual
    assert not accepted(robot), 'it released what the switch had stopped'
    throw(robot, stopped=False)
    time.sleep(0.5)  # virtual
    assert accepted(robot)
    say(True)
    time.sleep(0.5)  # virtual
    reason = '/stranger says so on emergency_stopped'
    assert status.messages[-1].message == reason
    assert not accepted(robot)
    stood = robot.joint('left_knee').position
    point = JointTrajectoryPoint(positions=[1.5])
    point.time_from_start.sec = 1
    commands.publish(JointTrajectory(joint_names=['left_knee'], points=[point]))
    time.sleep(0.5)  # virtual
    assert robot.joint('left_knee').position == stood
    client = robot.node.create_client(SetBool, 'emergency_stop')
    answer = call(client, SetBool.Request(data=False), 20.0)
    assert not answer.success
    assert answer.message == f'still stopped: {reason}'
    say(False)
    time.sleep(0.5)  # virtual
    assert accepted(robot), 'it has taken back its own word'
    assert status.messages[-1].message == 'released'


def test_a_stranger_that_leaves_a_stopped_robot_leaves_it_stopped(robot: Robot, stranger: Node) -> None:
    says(stranger)(True)
    time.sleep(1.5)  # virtual
    assert not accepted(robot)
    stranger.destroy_node()
    time.sleep(1.0)  # virtual
    assert not accepted(robot)
    assert throw(robot, stopped=False) == 'released'
    time.sleep(0.5)  # virtual
    assert accepted(robot)


def test_a_robot_that_never_had_a_switch_moves(gw_clock: VirtualClock, gw_graph: Graph) -> None:
    gw_graph.start(NavigationActionServer)
    time.sleep(5.0)  # virtual
    with Robot() as robot:
        assert accepted(robot)


def test_a_goal_that_comes_before_a_new_switch_has_spoken_waits_for_it(
    gw_clock: VirtualClock, gw_graph: Graph
) -> None:
    gw_graph.start(NavigationActionServer)  # it looks for switches every 0.2 s
    with Robot() as robot:
        assert accepted(robot)
        gw_graph.start(JointStateService)  # its switch speaks 0.2 s later
        time.sleep(0.19)  # virtual
        assert accepted(robot)


def test_a_goal_waits_only_a_second_for_a_switch_that_says_nothing(
    gw_clock: VirtualClock, gw_graph: Graph
) -> None:
    gw_graph.start(NavigationActionServer)
    with Robot() as robot:
        assert accepted(robot)
        mute = robot.node.create_publisher(Bool, 'emergency_stopped', LATCHED)
        robot.node.create_service(SetBool, 'emergency_stop', lambda _, response: response)
        time.sleep(0.5)  # virtual
        began = time.monotonic()
        assert not accepted(robot)
        assert time.monotonic() - began < 1.1, 's, virtual'
        assert not accepted(robot)
        mute.publish(Bool(data=False))
        time.sleep(0.1)  # virtual
        assert accepted(robot)


def accepted(robot: Robot) -> bool:
    with robot.drive(0.1, 0.0, allowed=10.0, timeout=20.0) as run:
        run.finish()
    return run.accepted


@pytest.mark.slow
@pytest.mark.timeout(400)
@on_both_wires
def test_it_stops_real_servers_under_load(world: dict[str, str]) -> None:
    """Goals of all kinds, while velocities and joint commands pour in; and when its switch is killed."""
    with ExitStack() as stack:
        servers = {
            name: stack.enter_context(humanoid(name, env=world))
            for name in ('joint_state_service', 'navigation_action_server', 'arm_action_server')
        }
        for server in servers.values():
            server.expect('ready')
        robot = stack.enter_context(robot_client())
        odometry: Collector[Odometry] = Collector()
        robot.node.create_subscription(Odometry, 'odom', odometry, 10)
        over = threading.Event()
        flood = threading.Thread(target=_flood, args=[robot, over])
        flood.start()
        stack.callback(flood.join)
        stack.callback(over.set)
        everything = Everything(robot)
        runs = everything.goals()
        assert all(run.accepted for run in runs)
        throw(robot, stopped=True)
        for run in runs:
            run.finish()
            assert run.status == 'ABORTED'
        assert not any(run.accepted for run in everything.goals())
        stands(odometry)
        before = {
            name: robot.joint(name, timeout=20.0) for name in ('right_knee', 'left_arm_shoulder', 'head_pan')
        }
        odometry.expect(len(odometry.items) + 20)
        for name, joint in before.items():
            assert not joint.is_moving
            assert robot.joint(name, timeout=20.0).position == joint.position
        throw(robot, stopped=False)
        moves(odometry)
        with robot.reach({'head_tilt': 0.2}, duration=1.0, timeout=30.0) as run:
            run.finish()
        assert run.status == 'SUCCEEDED'

        servers['joint_state_service'].kill()
        servers['navigation_action_server'].expect(f'EMERGENCY STOP: {re.escape(GONE)}')
        stands(odometry)
        with humanoid('joint_state_service', env=world) as again:
            again.expect('EMERGENCY STOP$')
            assert not any(run.accepted for run in everything.goals())
            throw(robot, stopped=False)
            moves(odometry)


def stands_as(base: NavigationActionServer, stopped: bool) -> bool:
    return base._stop.stopped is stopped


@pytest.mark.parametrize('medium', ['zenoh', 'dds'])
@pytest.mark.parametrize('qos', [LATCHED, QoSProfile(depth=1)], ids=['latched', 'volatile'])
def test_a_publisher_that_keeps_a_history_or_none_stops_and_releases(medium: str, qos: QoSProfile) -> None:
    if medium == 'dds':
        require(DDS)
    with Graph(medium) as graph:
        base = graph.start(NavigationActionServer)
        stranger = Node('stranger')
        publisher = stranger.create_publisher(Bool, 'emergency_stopped', qos)
        wait_for(lambda: publisher.get_subscription_count() > 0)
        for stopped in (True, False):
            publisher.publish(Bool(data=stopped))
            wait_for(partial(stands_as, base, stopped))
        stranger.destroy_node()


@pytest.mark.slow
@pytest.mark.timeout(400)
@on_both_wires
def test_nobody_but_the_switch_releases_real_servers(world: dict[str, str]) -> None:
    """Strangers say at 8 Hz that the robot is released, and velocities pour in all the time."""
    with ExitStack() as stack:
        switch, base = (
            stack.enter_context(humanoid(name, env=world))
            for name in ('joint_state_service', 'navigation_action_server')
        )
        for server in (switch, base):
            server.expect('ready')
        robot = stack.enter_context(robot_client())
        odometry: Collector[Odometry] = Collector()
        robot.node.create_subscription(Odometry, 'odom', odometry, 10)
        bag = robot.node.create_publisher(Bool, 'emergency_stopped', LATCHED)
        hand = robot.node.create_publisher(Bool, 'emergency_stopped', 1)
        for each in (bag, hand):
            robot.node.create_timer(0.13, partial(each.publish, Bool(data=False)))
        over = threading.Event()
        flood = threading.Thread(target=_flood, args=[robot, over])
        flood.start()
        stack.callback(flood.join)
        stack.callback(over.set)
        moves(odometry)
        throw(robot, stopped=True)
        stands(odometry)
        stands(odometry)
        switch.send_signal(signal.SIGSTOP)
        base.expect(f'EMERGENCY STOP: {re.escape(GONE)}')
        stands(odometry)
        switch.send_signal(signal.SIGCONT)
        stands(odometry)
        throw(robot, stopped=False)
        moves(odometry)


def stands(odometry: Collector[Odometry]) -> None:
    """The base stands, and goes on standing."""
    came = len(odometry.items)
    later = odometry.expect(came + 40)[came:]
    assert all(each.twist.twist.linear.x == 0.0 for each in later[-20:])


def moves(odometry: Collector[Odometry]) -> None:
    """Wait until the base moves; bounded by the test's time limit."""
    while odometry.expect(len(odometry.items) + 1)[-1].twist.twist.linear.x == 0.0:
        pass


def _flood(robot: Robot, over: threading.Event) -> None:
    """Velocities and joint commands, 400 of them a second."""
    velocities = robot.node.create_publisher(Twist, 'cmd_vel', 10)
    commands = robot.node.create_publisher(JointTrajectory, 'joint_command', 10)
    command = Twist()
    command.linear.x = 0.5
    angle = 0.1
    while not over.wait(0.005):
        angle = 0.6 - angle
        point = JointTrajectoryPoint(positions=[angle])
        point.time_from_start.nanosec = 500_000_000
        velocities.publish(command)
        commands.publish(JointTrajectory(joint_names=['right_knee'], points=[point]))
