"""What the arms' servers share: what is seen of the joints, which are taken, and the way to command them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence

from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.clock import duration_msg, now
from humanoid.model import JOINT_BY_NAME


class Limbs:
    """The joints as the last joint states show them, and `joint_command`."""

    def __init__(self, node: Node, on_sight: Callable[[], None]) -> None:
        """`on_sight` is called with each joint state that shows a joint of ours."""
        self.here: dict[str, float] = {}  # rad or m
        self.speeds: dict[str, float] = {}
        self.efforts: dict[str, float] = {}
        self.sights = 0  # how many joint states have come
        self.seen = 0.0  # s of the node's clock
        self.taken: set[str] = set()  # joints that move for a goal
        self._node, self._on_sight = node, on_sight
        self._commands = node.create_publisher(JointTrajectory, 'joint_command', 10)
        node.create_subscription(JointState, 'joint_states', self._see, 10)

    def _see(self, states: JointState) -> None:
        """Joint states need not name every joint; what is no angle of ours (NaN, a tail) is not seen."""
        positions = _numbers(states.name, states.position)
        if not positions:
            return
        self.here.update(positions)
        self.speeds.update(_numbers(states.name, states.velocity))
        self.efforts.update(_numbers(states.name, states.effort))
        self.seen = now(self._node)
        self.sights += 1
        self._on_sight()

    def command(self, names: Sequence[str], target: Sequence[float] = (), duration: float = 0.0) -> None:
        """Send the joints to `target` in `duration` seconds; without a target they hold still."""
        command = JointTrajectory(joint_names=list(names))
        if target:
            point = JointTrajectoryPoint(positions=list(target))
            point.time_from_start = duration_msg(duration)
            command.points.append(point)
        self._commands.publish(command)

    def send(self, trajectory: JointTrajectory) -> None:
        """Send a trajectory as it is."""
        self._commands.publish(trajectory)

    def take(self, names: Collection[str]) -> None:
        self.taken.update(names)

    def release(self, names: Collection[str]) -> None:
        self.taken.difference_update(names)


def _numbers(names: Sequence[str], values: Sequence[float]) -> Mapping[str, float]:
    return {
        name: value
        for name, value in zip(names, values, strict=False)
        if name in JOINT_BY_NAME and math.isfinite(value)
    }
