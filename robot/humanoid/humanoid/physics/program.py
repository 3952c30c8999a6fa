"""simulation: the body in MuJoCo, with its joints and its base behind their usual nodes, and its sensors.

One process stands in for joint_state_service and navigation_action_server. A timer of the steady clock lets
the world tick; everything runs on the executor's one thread, so nothing here needs a lock.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point, Quaternion, Vector3, WrenchStamped
from humanoid_interfaces.msg import Contact, Contacts
from humanoid_interfaces.srv import Push
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock as ClockMsg
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from humanoid.clock import NANOSECONDS, now, time_msg
from humanoid.description import urdf_text
from humanoid.diagnostics import Diagnostics, Health
from humanoid.emergency.names import make_latched_qos
from humanoid.joints.feet import SOLES
from humanoid.joints.service import JointStateService
from humanoid.model import JOINT_BY_NAME
from humanoid.navigation.messages import target_of
from humanoid.navigation.server import NavigationActionServer
from humanoid.physics.base import PhysicsBase
from humanoid.physics.joints import PhysicsJoints
from humanoid.physics.pace import Pace
from humanoid.physics.senses import USUAL, Noise
from humanoid.physics.touch import Touch
from humanoid.physics.walkers import find_walker, usual_walker
from humanoid.physics.world import PERIODS, TICK, Unstable, World
from humanoid.running import check_range, run
from humanoid.urdf import orientation
from humanoid.walking.names import BALANCING, FALLEN, GET_UP, LIES, PUSH

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time as TimeMsg

    from humanoid.physics.surroundings import Surroundings

PERIOD = 0.02  # s between two readings of the real clock; sensors and /clock are published at 50 Hz
GREATEST_PUSH = 2000.0  # N
LONGEST_PUSH = 5.0  # s
LOUDEST = 20.0  # the largest value of the parameter `noise`, a factor on the usual noise
LATEST = 20  # the largest delay of the sensors, in readings; one is taken each 5 ms


class Simulation(Node):
    """Lets a world tick in real time, and publishes the readings of its sensors."""

    def __init__(self) -> None:
        super().__init__('simulation')
        home = {joint.name: joint.home for joint in JOINT_BY_NAME.values()}
        seed = self.declare_parameter('seed', 0).value
        self._surroundings = self._build_world()
        around = None if self._surroundings is None else self._surroundings.add
        walker = find_walker(self.declare_parameter('walker', usual_walker()).value)
        self.world = world = World(urdf_text(), home, seed, self._noise(), walker=walker, around=around)
        self.failure: str | None = None
        self._pace: Pace | None = None
        self._told_factor, self._told_energy = 0.0, world.energy
        self._fallen = False
        prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        self._imu_frame, self._sole_frames = f'{prefix}imu_link', [f'{prefix}{sole}' for sole in SOLES]
        self._prefix, self._touches = prefix, False
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
        self._contacts = self.create_publisher(Contacts, 'contacts', 10)
        self._falls = self.create_publisher(Bool, FALLEN, make_latched_qos())
        self._falls.publish(Bool(data=False))
        self._balancing = self.create_publisher(String, BALANCING, make_latched_qos())
        legs = [name for name in JOINT_BY_NAME if world.balances(name)]
        self._balancing.publish(String(data=','.join(legs)))
        self._diagnostics = Diagnostics(self, 'balance', self._health)
        self.create_service(Push, PUSH, self._push)
        self.create_service(Trigger, GET_UP, self._get_up)
        self.create_timer(PERIOD, self._advance, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _build_world(self) -> Surroundings | None:
        """Build the surroundings that the parameter `world` names; they follow the topic `world_markers`."""
        world = self.declare_parameter('world', '').get_parameter_value().string_value
        if not world:
            return None
        from humanoid.physics.surroundings import surroundings_of  # needs packages that only worlds require

        self.create_subscription(MarkerArray, 'world_markers', self._arrange, make_latched_qos())
        return surroundings_of(world)

    def _arrange(self, markers: MarkerArray) -> None:
        """Move doors and people to their places in the world's markers."""
        if self._surroundings is None:
            return
        places = {}
        for marker in markers.markers:
            at = target_of(marker.pose)
            places[f'{marker.ns} {marker.text}'] = at.x, at.y, at.yaw
        self.world.arrange(partial(self._surroundings.arrange, places=places))

    def _noise(self) -> Noise:
        """Return the sensors' noise and delay, by the parameters `noise` (factor) and `sensor_delay` (s)."""
        loud = self.declare_parameter('noise', 1.0).get_parameter_value().double_value
        late = self.declare_parameter('sensor_delay', 0.0).get_parameter_value().double_value
        check_range('noise', loud, 0.0, LOUDEST)
        check_range('sensor_delay', late, 0.0, LATEST * TICK / PERIODS)
        return replace(USUAL.times(loud), delay=round(late / (TICK / PERIODS)))

    def _push(self, request: Push.Request, response: Push.Response) -> Push.Response:
        force = (request.force.x, request.force.y, request.force.z)
        size = math.hypot(*force)
        if not size <= GREATEST_PUSH or not 0.0 < request.duration <= LONGEST_PUSH:
            response.message = (
                f'a push has at most {GREATEST_PUSH:g} N and {LONGEST_PUSH:g} s, '
                f'not {size:g} N and {request.duration:g} s'
            )
            return response
        self.world.push(force, request.duration)
        response.success, response.message = True, f'pushed with {size:.0f} N for {request.duration:g} s'
        self.get_logger().info(response.message)
        return response

    def _get_up(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self.world.fallen
        response.message = 'the robot has not fallen'
        if self.world.fallen:
            self.world.get_up()
            response.message = (
                'the simulation has put the robot back on its feet: it cannot climb up by itself'
            )
        self.get_logger().info(response.message)
        return response

    def _health(self) -> Health:
        world = self.world
        values = {
            'pelvis height': f'{world.estimate.height:.3f}',
            'roll': f'{world.estimate.roll:.3f}',
            'pitch': f'{world.estimate.pitch:.3f}',
            'load left': f'{world.loads[0]:.0f}',
            'load right': f'{world.loads[1]:.0f}',
        }
        if world.fallen:
            return Health(LIES, DiagnosticStatus.ERROR, values)
        return Health('walking' if world.walking else 'standing', values=values)

    def _advance(self) -> None:
        if self.failure is not None:
            return
        if self._pace is None:  # time starts only now, when the other nodes are up
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
        touches = world.touches()
        if touches or self._touches:  # an empty message says that the touch has ended
            self._contacts.publish(_contacts(touches, self._prefix, stamp))
        self._touches = bool(touches)
        energy, self._told_energy = self._told_energy, world.energy
        self._power.publish(Float64(data=(world.energy - energy) / (ticks * TICK)))
        if world.time - self._told_factor >= 1.0:
            self._told_factor = world.time
            self._factor.publish(Float64(data=factor))
        if world.fallen is not self._fallen:
            self._fallen = world.fallen
            self._falls.publish(Bool(data=world.fallen))
            if world.fallen:
                self.get_logger().error(f'{LIES}: its pelvis is {world.pelvis_height:.2f} m up')

    def _stamp(self) -> TimeMsg:
        """Return the stamp for messages: the world's time with `use_sim_time`, else the node's time."""
        if self.get_parameter('use_sim_time').value:
            return time_msg(round(self.world.time * NANOSECONDS))
        return time_msg(self.get_clock().now().nanoseconds)


def _imu(world: World, stamp: TimeMsg, frame: str) -> Imu:
    message, shown = Imu(), world.inertial
    message.header.stamp, message.header.frame_id = stamp, frame
    estimate = world.estimate
    turn = orientation(estimate.roll, estimate.pitch, estimate.pose.yaw)
    message.orientation = Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3])
    rate, pull = message.angular_velocity, message.linear_acceleration
    rate.x, rate.y, rate.z = shown.turn_rate
    pull.x, pull.y, pull.z = shown.acceleration
    return message


def _contacts(touches: Sequence[Touch], prefix: str, stamp: TimeMsg) -> Contacts:
    """Return touches as a message; `prefix` stands before the names of links, as in TF."""
    message = Contacts()
    message.header.stamp = stamp
    for touch in touches:
        (x, y, z), (fx, fy, fz) = touch.position.tolist(), touch.force.tolist()
        place, force = Point(x=x, y=y, z=z), Vector3(x=fx, y=fy, z=fz)
        message.contacts.append(
            Contact(link=f'{prefix}{touch.link}', thing=touch.thing, position=place, force=force)
        )
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
