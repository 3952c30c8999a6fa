"""Connects the guard of the base to the scanner's topic."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from humanoid.clock import now
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.navigation.guard import Guard


class Surroundings:
    """Subscribes to the scanner, and limits the base's velocity by its scans."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._guard = Guard()
        node.create_subscription(LaserScan, 'scan', self._guard.hear, qos_profile_sensor_data)

    def limit(self, wish: Velocity2D, pose: Pose2D) -> Velocity2D:
        """Return the part of a velocity that keeps the base away from what the scanner sees."""
        allowed = self._guard.limit(wish, pose, now(self._node))
        if allowed != wish:
            self._node.get_logger().warning(
                'cmd_vel is slowed down or stopped: something is near, or there is no scan',
                throttle_duration_sec=2.0,
            )
        return allowed

    def note_pose(self, moment: float, pose: Pose2D) -> None:
        """Remember the base's pose at a moment (s): a scan taken at that moment arrives later."""
        self._guard.note_pose(moment, pose)
