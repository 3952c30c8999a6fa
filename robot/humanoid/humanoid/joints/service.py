"""joint_state_service: answers `get_joint_state`, publishes `joint_states`, obeys `joint_command`.

This node controls the joints, so it also has the switch of the emergency stop.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from humanoid_interfaces.srv import GetJointState
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from humanoid.clock import now, seconds, stamp
from humanoid.diagnostics import Diagnostics, Health
from humanoid.driver.seam import HOLD_AFTER, DrivenJoints, DriverError
from humanoid.emergency.names import REFUSAL
from humanoid.emergency.switch import StopSwitch
from humanoid.joints import feet
from humanoid.joints.commands import CommandRefused, plan
from humanoid.joints.kinematic import KinematicJoints
from humanoid.joints.messages import points_of
from humanoid.joints.source import JointSource, read_all
from humanoid.running import check_range, run
from humanoid.text import LONGEST_NAME, brief

RATE = 50.0  # Hz
LONGEST_HOLD = 60.0  # s: the largest value of the parameter `hold_after`


class JointStateService(Node):
    """Controls the joints; other nodes query and command them here. Pass a JointSource for real joints."""

    def __init__(self, source: JointSource | None = None) -> None:
        super().__init__('joint_state_service')
        port = self.declare_parameter('serial_port', '').get_parameter_value().string_value
        hold_after = self.declare_parameter('hold_after', HOLD_AFTER).get_parameter_value().double_value
        self._driven = _open_driven(port, now(self), hold_after) if port and source is None else None
        source = source or self._driven
        self._source: JointSource = source or KinematicJoints(now=now(self))
        self._trouble: str | None = None
        self._prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        self._weight = feet.weight()
        self._soles = {  # wrenches of the soles; a JointSource passed in publishes its own
            sole: self.create_publisher(WrenchStamped, f'{sole}/wrench', qos_profile_sensor_data)
            for sole in (feet.SOLES if source is None else ())
        }
        self._states = self.create_publisher(JointState, 'joint_states', 10)
        self._stop = StopSwitch(self, self._hold)
        self._diagnostics = Diagnostics(self, 'joints', self._health)
        self.create_subscription(JointTrajectory, 'joint_command', self._obey, 10)
        self.create_timer(1.0 / RATE, self._tick)
        self.create_service(GetJointState, 'get_joint_state', self._answer)
        self.get_logger().info('Joint State Service ready')

    def destroy_node(self) -> None:
        if self._driven is not None:
            self._driven.close()
        super().destroy_node()

    def _answer(
        self, request: GetJointState.Request, response: GetJointState.Response
    ) -> GetJointState.Response:
        joint_name = request.joint_name
        if joint_name in self._source.joints:
            sample = self._source.read(joint_name)
            response.position = sample.position
            response.velocity = sample.velocity
            response.effort = sample.effort
            response.is_moving = sample.is_moving
            self.get_logger().info(f'Served joint state for: {joint_name}')
        else:
            self.get_logger().warning(f'Unknown joint: {brief(joint_name, LONGEST_NAME)}')
            response.position = 0.0
            response.velocity = 0.0
            response.effort = 0.0
            response.is_moving = False
        return response

    def _hold(self) -> None:
        """Make every joint hold its position."""
        self._source.follow({name: [] for name in self._source.joints}, now(self))

    def _health(self) -> Health:
        moving = [name for name, sample in read_all(self._source) if sample.is_moving]
        values = {'joints': len(self._source.joints), 'moving': brief(', '.join(moving)) or 'none'}
        if self._trouble is not None:
            return Health(brief(self._trouble), DiagnosticStatus.ERROR, values)
        if self._stop.stopped:
            return Health('emergency stop', DiagnosticStatus.WARN, values)
        return Health('moving' if moving else 'still', values=values)

    def _obey(self, command: JointTrajectory) -> None:
        if self._stop.stopped:
            if command.points:
                self.get_logger().warning(f'Ignored a joint command: {REFUSAL}', throttle_duration_sec=1.0)
            return
        names = command.joint_names or list(self._source.joints)
        try:
            motion = plan(names, points_of(command), self._source.joints)
            self._source.follow(motion, seconds(command.header.stamp) or now(self))
        except CommandRefused as refused:
            self.get_logger().warning(f'Ignored a joint command: {brief(str(refused))}')

    def _tick(self) -> None:
        try:
            self._source.update(now(self))
            samples = read_all(self._source)
        except Exception as error:  # nothing is published: joint states would show old values
            self._trouble = f'{type(error).__name__}: {error}'
            raise
        self._trouble = None
        states = JointState()
        states.header.stamp = stamp(self)
        for name, sample in samples:
            states.name.append(name)
            states.position.append(sample.position)
            states.velocity.append(sample.velocity)
            states.effort.append(sample.effort)
        self._states.publish(states)
        if self._soles:
            self._tell_loads(states)

    def _tell_loads(self, states: JointState) -> None:
        positions = dict(zip(states.name, states.position, strict=True))
        for sole, load in feet.loads(positions, self._weight).items():
            wrench = WrenchStamped()
            wrench.header.stamp, wrench.header.frame_id = states.header.stamp, f'{self._prefix}{sole}'
            wrench.wrench.force.z = load
            self._soles[sole].publish(wrench)


def _open_driven(port: str, moment: float, hold_after: float) -> DrivenJoints:
    """Open the driver of the motors. Raises DriverError and BadParameter."""
    check_range('hold_after', hold_after, 0.02, LONGEST_HOLD)
    from humanoid.driver.serial import SerialMotors  # imported here: this module exists only on POSIX

    return DrivenJoints(SerialMotors(port), now=moment, hold_after=hold_after)


def main(args: Sequence[str] | None = None) -> int:
    try:
        return run(JointStateService, args)
    except DriverError as error:
        print(f'joint_state_service: {brief(str(error))}', file=sys.stderr)
        return 1


if __name__ == '__main__':
    raise SystemExit(main())
