"""draw_square and mimic: programs that read a turtle's pose and command a turtle."""

from __future__ import annotations

import math
from collections.abc import Sequence

from geometry_msgs.msg import Twist
from rclpy.node import Node
from std_srvs.srv import Empty
from turtlesim.msg import Pose

from goalwire.apps.programs.running import spin
from goalwire.apps.programs.turtlesim.world import normalize

SIDE = 2.0
"""The side of the square, in units."""
FORWARD, TURN = 1.0, 0.4
NEAR, NEAR_RAD = 0.1, 0.01


class DrawSquare(Node):
    """Resets the simulator, and has turtle1 draw squares."""

    def __init__(self) -> None:
        super().__init__('draw_square')
        self._publisher = self.create_publisher(Twist, 'turtle1/cmd_vel', 1)
        self._pose: Pose | None = None
        self._goal: tuple[float, float, float] | None = None  # a pose: x, y, theta
        self._turns = False
        self._stops = False
        self._reset = self.create_client(Empty, 'reset')
        self._reset.wait_for_service()
        self._reset.call_async(Empty.Request()).add_done_callback(lambda _: self._begin())

    def _begin(self) -> None:
        self.create_subscription(Pose, 'turtle1/pose', self._see, 1)
        self.create_timer(0.016, self._step)

    def _see(self, pose: Pose) -> None:
        self._pose = pose

    def _step(self) -> None:
        pose = self._pose
        if pose is None:
            return
        if self._goal is None:
            self._aim(pose)
        elif self._stops:
            self._command(0.0, 0.0)
            if abs(pose.linear_velocity) < 1e-4 and abs(pose.angular_velocity) < 1e-4:
                self.get_logger().info('Reached goal')
                self._turns = not self._turns
                self._aim(pose)
        elif self._is_there(pose):
            self._stops = True
        elif self._turns:
            self._command(0.0, TURN)
        else:
            self._command(FORWARD, 0.0)

    def _aim(self, pose: Pose) -> None:
        self._stops = False
        x, y, theta = pose.x, pose.y, pose.theta
        if self._turns:
            theta = normalize(theta + math.pi / 2)
        else:
            x, y = x + math.cos(theta) * SIDE, y + math.sin(theta) * SIDE
        self._goal = (x, y, theta)
        self.get_logger().info(f'New goal [{x:f} {y:f}, {theta:f}]')

    def _is_there(self, pose: Pose) -> bool:
        assert self._goal is not None
        x, y, theta = self._goal
        if self._turns:
            return abs(normalize(pose.theta - theta)) < NEAR_RAD
        return abs(pose.x - x) < NEAR and abs(pose.y - y) < NEAR

    def _command(self, forward: float, turn: float) -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = forward, turn
        self._publisher.publish(twist)


class Mimic(Node):
    """Publishes the speeds of `input/pose` on `output/cmd_vel`."""

    def __init__(self) -> None:
        super().__init__('turtle_mimic')
        self._publisher = self.create_publisher(Twist, 'output/cmd_vel', 1)
        self.create_subscription(Pose, 'input/pose', self._follow, 1)

    def _follow(self, pose: Pose) -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = pose.linear_velocity, pose.angular_velocity
        self._publisher.publish(twist)


def draw_square(args: Sequence[str] | None = None) -> int:
    """Run draw_square."""
    return spin(DrawSquare, args)


def mimic(args: Sequence[str] | None = None) -> int:
    """Run mimic."""
    return spin(Mimic, args)
