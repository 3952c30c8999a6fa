"""simulation: the body in MuJoCo, with its joints and its base behind their usual nodes, and its sensors.

One process stands in for joint_state_service and navigation_action_server. A timer of the steady clock lets
the world tick; everything runs on the executor's one thread, so nothing here needs a lock.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock as ClockMsg
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

from humanoid.clock import NANOSECONDS, now, time_msg
from humanoid.description import urdf_text
from humanoid.joints.feet import SOLES
from humanoid.joints.service import JointStateService
from humanoid.model import JOINT_BY_NAME
from humanoid.navigation.server import NavigationActionServer
from humanoid.physics.base import PhysicsBase
from humanoid.physics.joints import PhysicsJoints
from humanoid.physics.pace import Pace
from humanoid.physics.world import TICK, Unstable, World
from humanoid.running import run

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time as TimeMsg

PERIOD = 0.02  # s between two looks at the real clock: sensors and /clock come at 50 Hz


class Simulation(Node):
    """Lets a world tick in real time, and tells what its sensors show."""

    def __init__(self) -> None:
        super().__init__('simulation')
        home = {joint.name: joint.home for joint in JOINT_BY_NAME.values()}
        seed = self.declare_parameter('seed', 0).value
        self.world = world = World(urdf_text(), home, seed)
        self.failure: str | None = None
        self._pace: Pace | None = None
        self._told_factor, self._told_energy = 0.0, world.energy
        self._fallen = False
        prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        self._imu_frame, self._sole_frames = f'{prefix}imu_link', [f'{prefix}{sole}' for sole in SOLES]
        self._clock_out = (
            self.create_publisher(ClockMsg, '/clock', 10)
            if self.declare_parameter('publish_clock', True).value
            else None
        )
        self._factor = self.create_publisher(Float64, 'real_time_factor', 10)
        self._power = self.create_publisher(Float64, 'motor_power', 10)
        self._imu = self.create_publisher(Imu, 'imu', qos_profile_sensor_data)
        self._soles = [
            self.create_publisher(WrenchStamped, f'{sole}/wrench', qos_profile_sensor_data) for sole in SOLES
        ]
        self.create_timer(PERIOD, self._advance, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _advance(self) -> None:
        if self.failure is not None:
            return
        if self._pace is None:  # the robot's other nodes are there by now
            self._pace = Pace(TICK, time.monotonic())
            robot = self.world.robot
            self.get_logger().info(f'Simulation ready: {robot.mass:.1f} kg, {len(robot.motors)} motors')
        due = self._pace.due(time.monotonic())
        try:
            for _ in range(due):
                self.world.tick()
        except Unstable as failure:
            self.failure = str(failure)
            self.get_logger().fatal(f'the simulation ends: {failure}')
            rclpy.try_shutdown()
            return
        if due:
            self._tell(due, self._pace.factor)

    def _tell(self, ticks: int, factor: float) -> None:
        world = self.world
        stamp = self._stamp()
        if self._clock_out is not None:
            self._clock_out.publish(ClockMsg(clock=time_msg(round(world.time * NANOSECONDS))))
        self._imu.publish(_imu(world, stamp, self._imu_frame))
        for publisher, frame, load in zip(self._soles, self._sole_frames, world.loads, strict=True):
            wrench = WrenchStamped()
            wrench.header.stamp, wrench.header.frame_id = stamp, frame
            wrench.wrench.force.z = load
            publisher.publish(wrench)
        energy, self._told_energy = self._told_energy, world.energy
        self._power.publish(Float64(data=(world.energy - energy) / (ticks * TICK)))
        if world.time - self._told_factor >= 1.0:
            self._told_factor = world.time
            self._factor.publish(Float64(data=factor))
        if world.fallen and not self._fallen:
            self.get_logger().error(f'the robot has fallen: its pelvis is {world.pelvis_height:.2f} m up')
        self._fallen = world.fallen

    def _stamp(self) -> TimeMsg:
        """The world's time where this node lives by it, else the node's clock."""
        if self.get_parameter('use_sim_time').value:
            return time_msg(round(self.world.time * NANOSECONDS))
        return time_msg(self.get_clock().now().nanoseconds)


def _imu(world: World, stamp: TimeMsg, frame: str) -> Imu:
    message, shown, yaw = Imu(), world.inertial, world.pose.yaw
    message.header.stamp, message.header.frame_id = stamp, frame
    message.orientation.z, message.orientation.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    turn, pull = message.angular_velocity, message.linear_acceleration
    turn.x, turn.y, turn.z = shown.turn_rate
    pull.x, pull.y, pull.z = shown.acceleration
    return message


def main(args: Sequence[str] | None = None) -> int:
    simulations: list[Simulation] = []

    def make_nodes() -> Iterator[Node]:
        simulation = Simulation()
        simulations.append(simulation)
        yield simulation
        yield JointStateService(PhysicsJoints(simulation.world, JOINT_BY_NAME, now(simulation)))
        yield NavigationActionServer(PhysicsBase(simulation.world))

    code = run(make_nodes, args)
    return 1 if any(simulation.failure for simulation in simulations) else code


if __name__ == '__main__':
    raise SystemExit(main())
