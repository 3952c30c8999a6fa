"""The base in a world: its guard hears the scanner."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from humanoid.clock import now
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.navigation.guard import Guard


class Surroundings:
    """The ears of the base for what is around it."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._guard = Guard()
        node.create_subscription(LaserScan, 'scan', self._guard.hear, qos_profile_sensor_data)

    def limit(self, wish: Velocity2D, pose: Pose2D) -> Velocity2D:
        """As much of a velocity as leaves room to what the scanner sees."""
        allowed = self._guard.limit(wish, pose, now(self._node))
        if allowed != wish:
            self._node.get_logger().warning(
                'cmd_vel is slowed down or stopped: something is near, or there is no scan',
                throttle_duration_sec=2.0,
            )
        return allowed

    def note_pose(self, moment: float, pose: Pose2D) -> None:
        """Remember where the base believes that it is at a moment (s), for scans that come later."""
        self._guard.note_pose(moment, pose)
