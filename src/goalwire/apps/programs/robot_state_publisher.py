"""robot_state_publisher: a robot's description on a topic, and the tree of its links as transforms.

Parameters, topics and rules are those of the ROS 2 package of this name: https://github.com/ros/robot_state_publisher
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from goalwire.apps.programs.running import declare_text, spin
from goalwire.transforms.rigid import Rigid
from goalwire.transforms.urdf import Joint, Kinematics, UrdfError, read_kinematics

NAME = 'robot_state_publisher'
FASTEST = 1000.0  # Hz
NANOSECONDS = 1_000_000_000
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RobotStatePublisher(Node):
    """Publishes `robot_description`, /tf_static for joints that are fixed and /tf for those that move.

    Parameters: `robot_description` (the URDF), `publish_frequency` (Hz, the most transforms of a joint a
    second; 0: no limit), `ignore_timestamp` (take each joint state, whatever its time) and `frame_prefix`.
    """

    def __init__(self, description: str = '', **options: object) -> None:
        """Make the node. `description` is the URDF if the parameter is empty. Raises UrdfError."""
        super().__init__(NAME, **options)  # type: ignore[arg-type]
        self._text = declare_text(self, 'robot_description', '') or description
        self.set_parameters([Parameter('robot_description', value=self._text)])
        rates = ParameterDescriptor(
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=FASTEST)]
        )
        self.declare_parameter('publish_frequency', 20.0, rates)
        self.declare_parameter('ignore_timestamp', value=False)
        self.declare_parameter('frame_prefix', '')
        self._read_settings()
        self._robot = read_kinematics(self._text)
        self._published: dict[str, int] = {}
        """The time of each joint's last published state, in ns."""
        self._last_state_at = 0
        self._description = self.create_publisher(String, 'robot_description', LATCHED)
        self._static = StaticTransformBroadcaster(self)
        self._moving = TransformBroadcaster(self)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        self.create_subscription(JointState, 'joint_states', self._take_state, qos_profile_sensor_data)
        self._publish_description()

    def _check_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == 'robot_description':
                try:
                    read_kinematics(parameter.get_parameter_value().string_value)
                except UrdfError as error:
                    return SetParametersResult(successful=False, reason=f'robot_description: {error}')
        return SetParametersResult(successful=True)

    def _take_parameters(self, parameters: Sequence[Parameter]) -> None:
        changed = {parameter.name for parameter in parameters}
        self._read_settings()
        if 'robot_description' in changed:
            self._text = self.get_parameter('robot_description').get_parameter_value().string_value
            self._robot = read_kinematics(self._text)
            self._published.clear()
            self._publish_description()
        elif 'frame_prefix' in changed:
            self._publish_fixed()

    def _read_settings(self) -> None:
        self._rate = self.get_parameter('publish_frequency').get_parameter_value().double_value
        self._ignore_timestamp = self.get_parameter('ignore_timestamp').get_parameter_value().bool_value
        self._prefix = self.get_parameter('frame_prefix').get_parameter_value().string_value

    def _publish_description(self) -> None:
        self._description.publish(String(data=self._text))
        self._publish_fixed()
        self.get_logger().info('Robot initialized')

    def _publish_fixed(self) -> None:
        now = self.get_clock().now().to_msg()
        fixed = [joint for joint in self._robot.joints if joint.kind == 'fixed']
        self._static.sendTransform([self._stamp(joint, joint.origin, now) for joint in fixed])

    def _take_state(self, state: JointState) -> None:
        if len(state.name) != len(state.position):
            self._tell_unusable(state)
            return
        now = self.get_clock().now().nanoseconds
        if now < self._last_state_at:
            self.get_logger().warning('Moved backwards in time, re-publishing joint transforms!')
            self._published.clear()
        self._last_state_at = now
        known = {joint.name for joint in self._robot.joints}
        given = {
            name: position
            for name, position in zip(state.name, state.position, strict=True)
            if name in known and math.isfinite(position)
        }
        moment = Time.from_msg(state.header.stamp).nanoseconds
        if not given or not self._is_due(given, moment):
            return
        self._published.update(dict.fromkeys(given, moment))
        self._moving.sendTransform(self._transforms(self._robot, given, state.header.stamp))

    def _tell_unusable(self, state: JointState) -> None:
        if state.position:
            self.get_logger().error(
                f'Ignored a joint state with {len(state.name)} names and {len(state.position)} positions',
                throttle_duration_sec=1.0,
            )
        else:
            self.get_logger().warning('Ignored a joint state without positions', once=True)

    def _is_due(self, given: Iterable[str], moment: int) -> bool:
        """Return True if the publish frequency allows another transform of the joint that waited longest."""
        if self._ignore_timestamp or not all(name in self._published for name in given):
            return True
        pause = NANOSECONDS / self._rate if self._rate > 0.0 else 0.0
        return moment >= min(self._published[name] for name in given) + pause

    def _transforms(
        self, robot: Kinematics, given: Mapping[str, float], moment: TimeMsg
    ) -> list[TransformStamped]:
        positions = robot.positions(given)
        return [
            self._stamp(joint, joint.motion(positions[joint.name]), moment)
            for joint in robot.joints
            if joint.is_movable and joint.name in positions
        ]

    def _stamp(self, joint: Joint, motion: Rigid, moment: TimeMsg) -> TransformStamped:
        message = TransformStamped(child_frame_id=f'{self._prefix}{joint.child}')
        message.header.stamp = moment
        message.header.frame_id = f'{self._prefix}{joint.parent}'
        x, y, z = motion.translation
        message.transform.translation = Vector3(x=x, y=y, z=z)
        x, y, z, w = motion.rotation
        message.transform.rotation = Quaternion(x=x, y=y, z=z, w=w)
        return message


def main(argv: Sequence[str] | None = None) -> int:
    """Run with the URDF of the parameter, or else of the given file; return the exit code."""
    arguments = list(sys.argv if argv is None else argv)
    words = remove_ros_args(arguments)[1:]
    if words in (['-h'], ['--help']):
        print(f'usage: {NAME} [URDF_FILE] [--ros-args -p robot_description:=URDF …]')
        return 0
    try:
        text = Path(words[0]).read_text(encoding='utf-8') if words else ''
        return spin(lambda: RobotStatePublisher(text), arguments)
    except (OSError, UnicodeDecodeError) as error:
        reason = f'{words[0]} cannot be read: {error}'
    except UrdfError as error:
        reason = f'the parameter robot_description: {error}'
    print(f'{NAME}: {reason}', file=sys.stderr)
    return 1
