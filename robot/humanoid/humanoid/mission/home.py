"""The way home: to the origin of `odom`, or of the frame `home` in a world, turned along its x axis."""

from __future__ import annotations

import math

from nav_msgs.msg import Odometry

from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.base import yaw_of

AT_HOME = 0.1  # m, and rad: a base that is nearer stands at home
UNHURRIED = 2.0  # times what a base at full speed takes: one in physics speeds up, and slows down
ROUND_THINGS = 8.0  # the same in a world: ways round walls and people are longer
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
    in_world = robot.in_world
    if allowed is None:
        hurry = ROUND_THINGS if in_world else UNHURRIED
        allowed = LEAST + hurry * distance_home(odometry) / BASE.max_speed
    frame = 'home' if in_world else 'odom'
    return robot.drive(0.0, 0.0, allowed=allowed, timeout=allowed + ENDS_WITHIN, frame=frame)
