"""The base in a world: its guard hears the scanner, and the simulation's truth of where it is goes out."""

from __future__ import annotations

from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from humanoid.clock import now, seconds
from humanoid.navigation.base import MobileBase, Pose2D, Velocity2D
from humanoid.navigation.guard import Guard
from humanoid.navigation.messages import odometry

TRUTH = 'ground_truth'
HOME = 'home'  # the frame in which a world has the place where the robot was brought up


class Surroundings:
    """The ears of the base for what is around it."""

    def __init__(self, node: Node, prefix: str, *, is_kinematic: bool) -> None:
        """`is_kinematic`: the base is its own truth. A simulation of the body may tell that itself."""
        self._node, self._prefix = node, prefix
        self._guard = Guard()
        tells = is_kinematic or not node.count_publishers(TRUTH)
        self._truth = node.create_publisher(Odometry, TRUTH, 10) if tells else None
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

    def tell(self, base: MobileBase, stamp: TimeMsg) -> None:
        """Publish where the base is in truth, as seen from where it was brought up.

        Only the simulated world and tests may listen.
        """
        self._guard.note_pose(seconds(stamp), base.pose)
        if self._truth is not None:
            self._truth.publish(odometry(base, base.pose, HOME, stamp, self._prefix))
