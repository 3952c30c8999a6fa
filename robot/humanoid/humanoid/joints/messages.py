"""Joint commands as ROS messages."""

from __future__ import annotations

from collections.abc import Sequence

from trajectory_msgs.msg import JointTrajectory

from humanoid.clock import seconds
from humanoid.joints.commands import Point


def points_of(trajectory: JointTrajectory) -> Sequence[Point]:
    return [
        Point(seconds(point.time_from_start), point.positions, point.velocities, point.accelerations)
        for point in trajectory.points
    ]
