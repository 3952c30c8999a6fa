"""The topic on which a simulated base publishes its true pose."""

from __future__ import annotations

from builtin_interfaces.msg import Time as TimeMsg
from nav_msgs.msg import Odometry
from rclpy.node import Node

from humanoid.navigation.base import SimulatedBase
from humanoid.navigation.messages import odometry

TRUTH = 'ground_truth'  # nav_msgs/Odometry
HOME = 'home'  # the frame whose origin is the robot's start pose


class TruthTeller:
    """Publishes the true pose in a simulation, for the simulated world, benchmarks and tests only."""

    def __init__(self, node: Node, base: SimulatedBase, prefix: str) -> None:
        self._base, self._prefix = base, prefix
        self._publisher = node.create_publisher(Odometry, TRUTH, 10)

    def tell(self, stamp: TimeMsg) -> None:
        """Publish the true pose of the base now."""
        truth = self._base.truth
        self._publisher.publish(odometry(truth, truth.pose, HOME, stamp, self._prefix))
