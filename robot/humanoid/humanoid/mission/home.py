"""The way home: the base at the origin of `odom`, turned along its x axis."""

from __future__ import annotations

import math

from nav_msgs.msg import Odometry

from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.base import yaw_of

AT_HOME = 0.1  # m, and rad: a base that is nearer stands at home
UNHURRIED = 2.0  # times what a base at full speed takes: one in physics speeds up, and slows down
LEAST = 10.0  # s: to turn round takes time, too
ENDS_WITHIN = 5.0  # s beyond what the goal itself may take


def distance_home(odometry: Odometry) -> float:
    """How far the base is from home, in m."""
    place = odometry.pose.pose.position
    return math.hypot(place.x, place.y)


def is_at_home(odometry: Odometry) -> bool:
    turn = odometry.pose.pose.orientation
    yaw = yaw_of(turn.x, turn.y, turn.z, turn.w)
    return distance_home(odometry) <= AT_HOME and abs(yaw) <= AT_HOME


def drive_home(robot: Robot, odometry: Odometry, allowed: float | None = None) -> GoalRun:
    """Send the base home from where it is; `allowed` s for the way, or else twice what it needs."""
    if allowed is None:
        allowed = LEAST + UNHURRIED * distance_home(odometry) / BASE.max_speed
    return robot.drive(0.0, 0.0, allowed=allowed, timeout=allowed + ENDS_WITHIN)
