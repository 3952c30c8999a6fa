"""The topic on which a simulated base tells where it really is."""

from __future__ import annotations

from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import Odometry
from rclpy.node import Node

from humanoid.navigation.base import SimulatedBase
from humanoid.navigation.messages import odometry

TRUTH = 'ground_truth'  # nav_msgs/Odometry
HOME = 'home'  # the frame of the place where the robot was brought up


class TruthTeller:
    """Publishes the true pose in a simulation, for the simulated world, benchmarks and tests only."""

    def __init__(self, node: Node, base: SimulatedBase, prefix: str) -> None:
        self._base, self._prefix = base, prefix
        self._publisher = node.create_publisher(Odometry, TRUTH, 10)

    def tell(self, stamp: TimeMsg) -> None:
        """Publish where the base is now."""
        truth = self._base.truth
        self._publisher.publish(odometry(truth, truth.pose, HOME, stamp, self._prefix))
