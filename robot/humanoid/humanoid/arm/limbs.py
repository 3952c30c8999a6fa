"""Shared by the arms' action servers: the last joint states, the joints in use, sending joint commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence

from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.clock import duration_msg, now, seconds
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME

TICK = 0.05  # s between two ticks of a server; at each tick it checks the joints and sends feedback
OLDEST = 0.5  # s: joint states with an older stamp are taken as measured at their arrival
LOST = 'no joint states for a second: is joint_state_service running?'
_LOST_AFTER = round(1.0 / TICK)  # ticks without a joint state after which the joints count as lost


class Limbs:
    """Keeps the last joint states and publishes `joint_command`."""

    def __init__(self, node: Node, on_sight: Callable[[], None]) -> None:
        """`on_sight` is called after each joint state that names a joint of this robot."""
        self.here: dict[str, float] = {}  # rad or m
        self.speeds: dict[str, float] = {}
        self.efforts: dict[str, float] = {}
        self.sights = 0  # how many joint states have arrived
        self.seen = 0.0  # s of the node's clock: when the last joint state arrived
        self.measured = 0.0  # s of the node's clock: when the last joint state was measured
        self._looks = 0  # calls of look() since the last joint state
        self.taken: set[str] = set()  # joints that a running goal moves
        self._node, self._on_sight = node, on_sight
        self._commands = node.create_publisher(JointTrajectory, 'joint_command', 10)
        node.create_subscription(JointState, 'joint_states', self._see, 10)

    def _see(self, states: JointState) -> None:
        """Take joint states, which need not name every joint. NaN and joints of other robots are skipped."""
        positions = _numbers(states.name, states.position)
        if not positions:
            return
        self.here.update(positions)
        self.speeds.update(_numbers(states.name, states.velocity))
        self.efforts.update(_numbers(states.name, states.effort))
        self.seen = now(self._node)
        stamped = seconds(states.header.stamp)  # the stamp may be 0, or of another clock
        self.measured = stamped if 0.0 <= self.seen - stamped <= OLDEST else self.seen
        self.sights += 1
        self._looks = 0
        self._on_sight()

    def look(self) -> None:
        """Count one more tick without a joint state; the server calls this at each tick."""
        self._looks += 1

    @property
    def are_lost(self) -> bool:
        """Whether no joint state has arrived for a second.

        Ticks are counted, not seconds: joint states still queued for a delayed server do not count as lost.
        """
        return not self.here or self._looks > _LOST_AFTER

    def samples(self, names: Collection[str]) -> Mapping[str, JointSample]:
        """Return the last known samples of these joints; each must have been in a joint state already."""
        return {
            name: JointSample(self.here[name], self.speeds.get(name, 0.0), self.efforts.get(name, 0.0))
            for name in names
        }

    def command(self, names: Sequence[str], target: Sequence[float] = (), duration: float = 0.0) -> None:
        """Publish a command to reach `target` in `duration` seconds; without a target the joints hold."""
        command = JointTrajectory(joint_names=list(names))
        if target:
            point = JointTrajectoryPoint(positions=list(target))
            point.time_from_start = duration_msg(duration)
            command.points.append(point)
        self._commands.publish(command)

    def send(self, trajectory: JointTrajectory) -> None:
        """Publish a trajectory as the joint command, unchanged."""
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
