"""joint_state_publisher: publishes a position for every movable joint of a URDF."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from goalwire.apps.programs.joint_state_publisher.joints import JointSettings, JointTable, UnusableJointsError
from goalwire.apps.programs.running import UsageError, spin_with_words
from goalwire.transforms.urdf import Mimic, UrdfError, read_kinematics

NAME = 'joint_state_publisher'
USAGE = '[URDF_FILE] [--ros-args …]'
KINDS = {bool: 'true or false', int: 'a whole number', float: 'a number', list: 'a list of strings'}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
T = TypeVar('T', bool, int, float, list[str])


class JointStatePublisher(Node):
    """Publishes `joint_states` once it has a description, from a file or the topic `robot_description`.

    Parameters: `rate` (Hz), `publish_default_positions`, `_velocities`, `_efforts`, `use_mimic_tags`,
    `use_smallest_joint_limits`, `source_list` (topics whose joint states are taken over), `delta` (how far
    each joint moves between two messages), `zeros.JOINT` and `dependent_joints.JOINT.parent`, `.factor` and
    `.offset`.
    """

    table: JointTable | None = None

    def __init__(self, file: str | None = None, lock: threading.Lock | None = None) -> None:
        """Make the node. Raises UsageError for an invalid parameter or file. `lock` guards the joints."""
        super().__init__(NAME, automatically_declare_parameters_from_overrides=True)
        self.lock = threading.Lock() if lock is None else lock
        rate = self._declare('rate', 10)
        if rate <= 0:
            raise UsageError(f'the parameter rate is {rate}: it must be above 0')
        self._delta = self._declare('delta', 0.0)
        sources = self._declare('source_list', [''])
        self._settings = JointSettings(
            self._read_zeros(),
            self._read_dependents(),
            self._declare('use_mimic_tags', default=True),
            self._declare('use_smallest_joint_limits', default=True),
            self._declare('publish_default_positions', default=True),
            self._declare('publish_default_velocities', default=False),
            self._declare('publish_default_efforts', default=False),
        )
        if file is None:
            self.get_logger().info(
                'Waiting for robot_description to be published on the robot_description topic...'
            )
        else:
            self._read_file(file)
        self.create_subscription(String, 'robot_description', self._take_description, LATCHED)
        for source in filter(None, sources):
            self.create_subscription(JointState, source, self._take_states, 10)
        self._publisher = self.create_publisher(JointState, 'joint_states', 10)
        self.create_timer(1.0 / rate, self._publish)

    def show(self) -> None:
        """Do nothing; joint_state_publisher_gui shows the joints in its window here. `lock` is held."""

    def _declare(self, name: str, default: T) -> T:
        """Declare a parameter and return its value. Raises UsageError if its type is not the default's."""
        if not self.has_parameter(name):
            self.declare_parameter(name, default)
        value: Any = self.get_parameter(name).value
        if type(default) is float and type(value) is int:
            value = float(value)
        if type(value) is not type(default):
            raise UsageError(f'the parameter {name} is {value!r}: it must be {KINDS[type(default)]}')
        return value

    def _read_zeros(self) -> dict[str, float]:
        found = {name: parameter.value for name, parameter in self.get_parameters_by_prefix('zeros').items()}
        return {name: _to_number(f'zeros.{name}', value) for name, value in found.items()}

    def _read_dependents(self) -> dict[str, Mimic]:
        parts: dict[str, dict[str, Any]] = {}
        for name, parameter in self.get_parameters_by_prefix('dependent_joints').items():
            joint, _, part = name.rpartition('.')
            if not joint or part not in {'parent', 'factor', 'offset'}:
                raise UsageError(
                    f'the parameter dependent_joints.{name} does not end with .parent, .factor or .offset'
                )
            parts.setdefault(joint, {})[part] = parameter.value
        return {joint: _to_mimic(joint, given) for joint, given in parts.items()}

    def _read_file(self, file: str) -> None:
        try:
            self._set_description(Path(file).read_text(encoding='utf-8'))
        except (OSError, UnicodeDecodeError, UrdfError, UnusableJointsError) as error:
            raise UsageError(f'{file} cannot be used: {error}') from None

    def _take_description(self, message: String) -> None:
        try:
            self._set_description(message.data)
        except (UrdfError, UnusableJointsError) as error:
            self.get_logger().warning(f'The robot_description cannot be used: {error}')

    def _set_description(self, text: str) -> None:
        """Make the joint table of a URDF. Raises UrdfError and UnusableJointsError."""
        table = JointTable(read_kinematics(text), self._settings)
        with self.lock:
            self.table = table
            self.show()

    def _take_states(self, message: JointState) -> None:
        with self.lock:
            if self.table is not None:
                self.table.take(message.name, message.position, message.velocity, message.effort)
                self.show()

    def _publish(self) -> None:
        message = JointState()
        message.header.stamp = self.get_clock().now().to_msg()
        with self.lock:
            if self.table is None:
                return
            if self._delta > 0:
                self.table.move(self._delta)
                self.show()
            message.name, message.position, message.velocity, message.effort = self.table.fill()
        if message.name:
            self._publisher.publish(message)


def _to_number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise UsageError(f'the parameter {name} is {value!r}: it must be a number')
    return float(value)


def _to_mimic(joint: str, given: Mapping[str, Any]) -> Mimic:
    parent = given.get('parent')
    if not isinstance(parent, str) or not parent:
        raise UsageError(f'dependent_joints.{joint}.parent must name the joint that {joint} follows')
    factor = _to_number(f'dependent_joints.{joint}.factor', given.get('factor', 1.0))
    return Mimic(parent, factor, _to_number(f'dependent_joints.{joint}.offset', given.get('offset', 0.0)))


def main(argv: Sequence[str] | None = None) -> int:
    """Publish until Ctrl-C; returns the exit code."""
    return spin_with_words(NAME, USAGE, lambda words: JointStatePublisher(_only(words)), argv)


def _only(words: list[str]) -> str | None:
    if len(words) > 1:
        raise UsageError(f"'{words[1]}' is not understood")
    return words[0] if words else None
