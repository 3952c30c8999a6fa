"""The way home: to the origin of `odom`, or of the frame `home` in a world, turned along its x axis."""

from __future__ import annotations

import math

from nav_msgs.msg import Odometry

from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.base import yaw_of

AT_HOME = 0.1  # m and rad: a base within this distance counts as at home
UNHURRIED = 2.0  # times the time at full speed: a base with physics speeds up and slows down
ROUND_THINGS = 8.0  # the same in a world: the way round walls and people is longer
LEAST = 10.0  # s at the least: turning round takes time, too
ENDS_WITHIN = 5.0  # s to wait for the result beyond the goal's own time


def distance_home(odometry: Odometry) -> float:
    """Return how far the base is from home, in m."""
    place = odometry.pose.pose.position
    return math.hypot(place.x, place.y)


def is_at_home(odometry: Odometry) -> bool:
    turn = odometry.pose.pose.orientation
    yaw = yaw_of(turn.x, turn.y, turn.z, turn.w)
    return distance_home(odometry) <= AT_HOME and abs(yaw) <= AT_HOME


def drive_home(robot: Robot, odometry: Odometry, allowed: float | None = None) -> GoalRun:
    """Send the base home within `allowed` s; by default twice the time that it needs."""
    in_world = robot.in_world
    if allowed is None:
        hurry = ROUND_THINGS if in_world else UNHURRIED
        allowed = LEAST + hurry * distance_home(odometry) / BASE.max_speed
    frame = 'home' if in_world else 'odom'
    return robot.drive(0.0, 0.0, allowed=allowed, timeout=allowed + ENDS_WITHIN, frame=frame)
