"""robot_state_publisher: the description on a topic, and the tree of its links as transforms.

It has the parameters, topics and rules of ROS 2's node of this name, which works in its place.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from humanoid.clock import NANOSECONDS, now, stamp
from humanoid.description import urdf_text
from humanoid.running import run
from humanoid.text import brief
from humanoid.urdf import BadDescription, Description, Transform, UrdfJoint, parse

FASTEST = 1000.0  # Hz


class RobotStatePublisher(Node):
    """Publishes `robot_description`, /tf_static for joints that are fixed and /tf for those that move.

    Parameters: `robot_description` (the URDF), `publish_frequency` (the most transforms a second of a joint),
    `ignore_timestamp` (take each joint state, whatever its time) and `frame_prefix`.
    """

    def __init__(self, description: str = '', **options: object) -> None:
        """`description` is the URDF where the parameter gives none. Raises BadDescription."""
        super().__init__('robot_state_publisher', **options)  # type: ignore[arg-type]
        self.declare_parameter('robot_description', description)
        rates = ParameterDescriptor(
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=FASTEST)]
        )
        self.declare_parameter('publish_frequency', 20.0, rates)
        self.declare_parameter('ignore_timestamp', value=False)
        self.declare_parameter('frame_prefix', '')
        self._read()
        self._robot = _described(self._text)
        self._published: dict[str, int] = {}  # the time of each joint's last transform, ns
        self._looked = 0.0
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._description = self.create_publisher(String, 'robot_description', latched)
        self._static = StaticTransformBroadcaster(self)
        self._moving = TransformBroadcaster(self)
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._take)
        self.create_subscription(JointState, 'joint_states', self._see, qos_profile_sensor_data)
        self._publish_description()
        self.get_logger().info('Robot State Publisher ready')

    def _check(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """A description that cannot be read, or a type that has changed, is refused with the reason."""
        for parameter in parameters:
            if parameter.name == 'robot_description':
                try:
                    _described(parameter.get_parameter_value().string_value)
                except BadDescription as bad:
                    return SetParametersResult(successful=False, reason=f'robot_description: {bad}')
        return SetParametersResult(successful=True)

    def _take(self, parameters: Sequence[Parameter]) -> None:
        changed = {parameter.name for parameter in parameters}
        self._read()
        if 'robot_description' in changed:
            self._robot = _described(self._text)
            self._published.clear()
            self._publish_description()
        elif 'frame_prefix' in changed:
            self._publish_fixed()

    def _read(self) -> None:
        self._text = self.get_parameter('robot_description').get_parameter_value().string_value
        self._rate = self.get_parameter('publish_frequency').get_parameter_value().double_value
        self._ignore_timestamp = self.get_parameter('ignore_timestamp').get_parameter_value().bool_value
        self._prefix = self.get_parameter('frame_prefix').get_parameter_value().string_value

    def _publish_description(self) -> None:
        self._description.publish(String(data=self._text))
        self._publish_fixed()

    def _publish_fixed(self) -> None:
        moment = stamp(self)
        fixed = [joint for joint in self._robot.joints.values() if joint.kind == 'fixed']
        self._static.sendTransform([self._stamped(joint, joint.origin, moment) for joint in fixed])

    def _see(self, states: JointState) -> None:
        if len(states.name) != len(states.position):
            if states.position:
                self.get_logger().error(
                    f'Ignored a joint state of {len(states.name)} names and {len(states.position)} positions',
                    throttle_duration_sec=1.0,
                )
            return  # without positions it tells of other things, which do not concern us
        moment = now(self)
        if moment < self._looked:
            self.get_logger().warning('The time went backwards: all transforms are published anew')
            self._published.clear()
        self._looked = moment
        given = {
            name: position
            for name, position in zip(states.name, states.position, strict=True)
            if name in self._robot.joints and math.isfinite(position)
        }
        if not given or not self._due(given, states.header.stamp):
            return
        positions = self._robot.positions(given)
        moving = [joint for name in positions if (joint := self._robot.joints[name]).moves]
        self._moving.sendTransform(
            [
                self._stamped(joint, joint.transform(positions[joint.name]), states.header.stamp)
                for joint in moving
            ]
        )

    def _due(self, given: Mapping[str, float], moment: TimeMsg) -> bool:
        """Whether the joint that was published longest ago may be published again; notes it then."""
        nanoseconds = moment.sec * NANOSECONDS + moment.nanosec
        oldest = min(self._published.get(name, -NANOSECONDS) for name in given)
        pause = NANOSECONDS / self._rate if self._rate > 0.0 else 0.0
        if not self._ignore_timestamp and oldest >= 0 and nanoseconds < oldest + pause:
            return False
        self._published.update(dict.fromkeys(given, nanoseconds))
        return True

    def _stamped(self, joint: UrdfJoint, where: Transform, moment: TimeMsg) -> TransformStamped:
        message = TransformStamped(child_frame_id=f'{self._prefix}{joint.child}')
        message.header.stamp = moment
        message.header.frame_id = f'{self._prefix}{joint.parent}'
        x, y, z = where.translation
        message.transform.translation = Vector3(x=x, y=y, z=z)
        x, y, z, w = where.rotation
        message.transform.rotation = Quaternion(x=x, y=y, z=z, w=w)
        return message


def _described(text: str) -> Description:
    """Raises BadDescription."""
    if not text.strip():
        raise BadDescription('it is empty')
    return parse(text)


def main(args: Sequence[str] | None = None) -> int:
    """The URDF is the parameter's, or that of the file that is named, or the humanoid's."""
    arguments = list(sys.argv[1:] if args is None else args)
    given = arguments.pop(0) if arguments and not arguments[0].startswith('-') else None
    try:
        text = urdf_text() if given is None else Path(given).read_text(encoding='utf-8')
        return run(lambda: RobotStatePublisher(text), arguments)
    except (OSError, UnicodeDecodeError) as error:
        reason = f'{given or "the description"} cannot be read: {error}'
    except BadDescription as bad:
        reason = f'robot_description: {brief(str(bad))}'
    print(f'robot_state_publisher: {reason}', file=sys.stderr)
    return 1


if __name__ == '__main__':
    raise SystemExit(main())
