"""Drives home: to the origin of `odom`, or in a world of the frame `home`, heading along the x axis."""

from __future__ import annotations

import math

from nav_msgs.msg import Odometry

from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.base import yaw_of

AT_HOME = 0.1  # m and rad: the base is at home within this distance and turn
UNHURRIED = 2.0  # factor on the time at full speed: a base with physics accelerates and brakes
ROUND_THINGS = 8.0  # factor on the time at full speed in a world: the way round walls and people is longer
LEAST = 10.0  # s added to the time for the way, because the base also has to turn
ENDS_WITHIN = 5.0  # s to wait for the result after the goal's own time limit


def distance_home(odometry: Odometry) -> float:
    """Return how far the base is from home, in m."""
    place = odometry.pose.pose.position
    return math.hypot(place.x, place.y)


def is_at_home(odometry: Odometry) -> bool:
    turn = odometry.pose.pose.orientation
    yaw = yaw_of(turn.x, turn.y, turn.z, turn.w)
    return distance_home(odometry) <= AT_HOME and abs(yaw) <= AT_HOME


def drive_home(robot: Robot, odometry: Odometry, allowed: float | None = None) -> GoalRun:
    """Send the base home; `allowed`: the goal's time limit in s, by default a multiple of the time needed."""
    in_world = robot.in_world
    if allowed is None:
        hurry = ROUND_THINGS if in_world else UNHURRIED
        allowed = LEAST + hurry * distance_home(odometry) / BASE.max_speed
    frame = 'home' if in_world else 'odom'
    return robot.drive(0.0, 0.0, allowed=allowed, timeout=allowed + ENDS_WITHIN, frame=frame)
