"""The base in a world: its guard hears the scanner, and the simulation's truth of where it is goes out."""

from __future__ import annotations

from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from humanoid.clock import now, seconds
from humanoid.navigation.base import MobileBase, Pose2D, Velocity2D, compose
from humanoid.navigation.guard import Guard
from humanoid.navigation.messages import odometry
from humanoid.running import BadParameter
from humanoid.world.file import load
from humanoid.world.names import BadWorld

MAP = 'map'


class Surroundings:
    """The ears of the base for what is around it."""

    def __init__(self, node: Node, world: str, prefix: str) -> None:
        """`world`: a name or a file, which says where the base begins. Raises BadParameter."""
        try:
            self._start = Pose2D(*load(world).start)
        except BadWorld as error:
            raise BadParameter(str(error)) from None
        self._node, self._prefix = node, prefix
        self._guard = Guard()
        self._truth = node.create_publisher(Odometry, 'ground_truth', 10)
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
        """Publish where the base is in truth; only the simulated world and tests may listen."""
        self._guard.note_pose(seconds(stamp), base.pose)
        self._truth.publish(odometry(base, compose(self._start, base.pose), MAP, stamp, self._prefix))
