"""The simulation as its own process, among the robot's other programs."""

from __future__ import annotations

import math
import re
import signal
from collections.abc import Iterator

import pytest
import rclpy
from geometry_msgs.msg import WrenchStamped
from helpers.collector import Collector
from helpers.processes import Program
from helpers.robot import humanoid
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64

from humanoid.mission.robot import Robot
from humanoid.physics.build import GRAVITY
from humanoid.physics.program import Simulation

pytestmark = pytest.mark.slow

SIM_TIME = ('--ros-args', '-p', 'use_sim_time:=true')
WITHIN = 30.0  # s


@pytest.fixture
def simulation(world: dict[str, str]) -> Iterator[Program]:
    with humanoid('simulation', *SIM_TIME, env=world) as program:
        program.expect('Simulation ready: 50.0 kg, 31 motors')
        yield program


def test_it_tells_the_time_and_what_its_sensors_show(simulation: Program, robot: Robot) -> None:
    clock: Collector[Clock] = Collector()
    factor: Collector[Float64] = Collector()
    power: Collector[Float64] = Collector()
    imu: Collector[Imu] = Collector()
    left: Collector[WrenchStamped] = Collector()
    right: Collector[WrenchStamped] = Collector()
    states: Collector[JointState] = Collector()
    node = robot.node
    node.create_subscription(Clock, '/clock', clock, 10)
    node.create_subscription(Float64, 'real_time_factor', factor, 10)
    node.create_subscription(Float64, 'motor_power', power, 10)
    node.create_subscription(JointState, 'joint_states', states, 10)
    node.create_subscription(Imu, 'imu', imu, qos_profile_sensor_data)
    node.create_subscription(WrenchStamped, 'left_sole/wrench', left, qos_profile_sensor_data)
    node.create_subscription(WrenchStamped, 'right_sole/wrench', right, qos_profile_sensor_data)
    moments = [tick.clock.sec + tick.clock.nanosec / 1e9 for tick in clock.expect(20, WITHIN)]
    assert moments == sorted(moments)
    assert moments[-1] < 600.0, "the time is the world's"
    assert 0.0 < factor.expect(1, WITHIN)[0].data < 1.5
    assert power.expect(1, WITHIN)[0].data < 5.0, 'W, standing'
    shown = imu.expect(1, WITHIN)[0]
    assert shown.linear_acceleration.z == pytest.approx(GRAVITY, abs=0.2)
    assert shown.header.stamp.sec < 600
    load = left.expect(1, WITHIN)[0].wrench.force.z + right.expect(1, WITHIN)[0].wrench.force.z
    assert load == pytest.approx(50.0 * GRAVITY, rel=0.02)
    state = states.expect(1, WITHIN)[0]
    assert len(state.name) == len(state.effort)
    assert state.header.stamp.sec < 600, 'its other nodes live by the same clock'


def test_the_base_walks_to_a_goal(simulation: Program, robot: Robot) -> None:
    loads: Collector[WrenchStamped] = Collector()
    robot.node.create_subscription(WrenchStamped, 'left_sole/wrench', loads, qos_profile_sensor_data)
    with robot.drive(0.8, 0.3, allowed=30.0, timeout=60.0) as run:
        assert run.accepted
        assert [feedback.distance_remaining for feedback in run.feedback()]
        assert run.status == 'SUCCEEDED'
        position = run.result.final_pose.pose.position
    assert math.dist((position.x, position.y), (0.8, 0.3)) < 0.05
    borne = [wrench.wrench.force.z for wrench in loads.expect(1, WITHIN)]
    assert min(borne) == 0.0, 'the foot was in the air'
    assert max(borne) > 400.0, 'it bore the robot alone'


def test_it_tells_the_truth_beside_what_the_robot_believes(simulation: Program, robot: Robot) -> None:
    truths: Collector[Odometry] = Collector()
    beliefs: Collector[Odometry] = Collector()
    robot.node.create_subscription(Odometry, 'ground_truth', truths, 100)
    robot.node.create_subscription(Odometry, 'odom', beliefs, 100)
    known = {stamp_of(each): each for each in beliefs.expect(50, WITHIN)}
    both = [(each, known[stamp_of(each)]) for each in truths.expect(50, WITHIN) if stamp_of(each) in known]
    assert len(both) > 10
    assert {truth.header.frame_id for truth, _ in both} == {'home'}
    off = [math.dist(*((of.pose.pose.position.x, of.pose.pose.position.y) for of in pair)) for pair in both]
    assert 0.0 < max(off) < 0.02, 'its sensors have noise'


def stamp_of(message: Odometry) -> tuple[int, int]:
    return message.header.stamp.sec, message.header.stamp.nanosec


DRIVER = """
import rclpy
from geometry_msgs.msg import Twist

rclpy.init()
node = rclpy.create_node('driver')
out = node.create_publisher(Twist, 'cmd_vel', 10)
forward = Twist()
forward.linear.x = 0.3
node.create_timer(0.1, lambda: out.publish(forward))
rclpy.spin(node)
"""


def test_a_driver_that_is_killed_leaves_the_robot_in_a_stand(
    simulation: Program, robot: Robot, world: dict[str, str]
) -> None:
    truths: Collector[Odometry] = Collector()
    robot.node.create_subscription(Odometry, 'ground_truth', truths, 100)
    with Program(DRIVER, env=world) as driver:
        truths.wait_for(lambda seen: bool(seen) and seen[-1].twist.twist.linear.x > 0.2)
        driver.send_signal(signal.SIGKILL)
        driver.wait()
    simulation.expect('Stopped: no newer velocity came for 0.5 s')
    last = truths.expect(len(truths.items) + 125)[-25:]  # 2.5 s of its time, and the last half second
    assert max(abs(each.twist.twist.linear.x) for each in last) < 0.05
    assert min(each.pose.pose.position.z for each in last) > 0.7
    assert 'has fallen' not in simulation.output


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_it_ends_when_told_to(simulation: Program, number: signal.Signals) -> None:
    simulation.send_signal(number)
    assert simulation.wait() == 0, simulation.output
    assert 'Traceback' not in simulation.output


@pytest.mark.usefixtures('world')
def test_numbers_that_are_none_end_it_with_the_reason(capfd: pytest.CaptureFixture[str]) -> None:
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = Simulation()
    node.world._data.qvel[4] = math.nan
    executor = rclpy.executors.SingleThreadedExecutor()
    executor.add_node(node)
    executor.spin()
    assert 'not a number' in (node.failure or '')
    assert not rclpy.ok()
    node.destroy_node()
    assert 'the simulation ends: after' in capfd.readouterr().err


@pytest.mark.long
@pytest.mark.timeout(400)
def test_the_demo_on_physics_in_simulated_time_ends_well(world: dict[str, str]) -> None:
    with humanoid('demo', '--physics', '--sim-time', env=world | {'COLUMNS': '160'}) as demo:
        output = demo.succeed(timeout=150.0)
    assert 'the body is simulated by MuJoCo' in output
    assert '13 of 13 steps ended as they should' in output
    for step in ('wave', 'open and close the left hand', 'emergency stop'):
        assert re.search(rf'^ok +{step} ', output, re.MULTILINE)
    assert 'both ABORTED, both refused; released: both SUCCEEDED' in output
    assert 'started simulation (pid' in output
    assert 'started joint_state_service' not in output


@pytest.mark.long
def test_a_robot_that_is_pushed_over_says_so_and_is_put_back(
    simulation: Program, robot: Robot, world: dict[str, str]
) -> None:
    """Its goal ends with the reason, the command line tells it too, and afterwards it drives again."""
    with humanoid('arm_action_server', *SIM_TIME, env=world) as arms:
        arms.expect('Arm Action Server ready')
        with robot.drive(3.0, 0.0, allowed=60.0, timeout=60.0) as run:
            next(run.feedback(), None)
            with humanoid('push', '700', '--direction', '90', '--duration', '0.3', env=world) as push:
                assert 'pushed with 700 N for 0.3 s' in push.succeed()
            run.finish()
            assert (run.status, run.result.message) == ('ABORTED', 'The robot has fallen')
        simulation.expect('the robot has fallen; humanoid get_up puts it back on its feet')
        with humanoid('wave', env=world) as wave:
            assert wave.wait() == 1
            assert 'the robot has fallen' in wave.output
        with robot.grip(0.05, timeout=60.0) as grip:
            assert not grip.accepted
        with humanoid('get_up', env=world) as get_up:
            assert 'it cannot climb up by itself' in get_up.succeed()
        with humanoid('arm', 'left_knee', '1.0', env=world) as knee:
            assert knee.wait() == 1
            assert 'left_knee keeps the robot on its feet and takes no commands' in knee.output
    with robot.drive(*_near(robot), allowed=30.0, timeout=60.0) as run:
        run.finish()
        assert run.status == 'SUCCEEDED'


def _near(robot: Robot) -> tuple[float, float]:
    """A place 0.3 m ahead of the robot's, in odom."""
    at = robot.next_message(Odometry, 'odom').pose.pose.position
    return at.x + 0.3, at.y
