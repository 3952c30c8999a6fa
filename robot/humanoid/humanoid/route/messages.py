"""Paths, poses and results of the navigator as ROS messages."""

from __future__ import annotations

import math
from itertools import pairwise

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import AssistedTeleop, ComputePathToPose, FollowPath
from nav_msgs.msg import Path

from humanoid.maps import Array
from humanoid.navigation.base import Pose2D
from humanoid.route.task import Failure

CODES = {
    Failure.NONE: ComputePathToPose.Result.NONE,
    Failure.NO_WAY: ComputePathToPose.Result.NO_VALID_PATH,
    Failure.STUCK: FollowPath.Result.FAILED_TO_MAKE_PROGRESS,
    Failure.LOST: ComputePathToPose.Result.TF_ERROR,
}
"""Nav2's error code for each failure of a drive that plans its way."""

PATH_CODES = {
    Failure.BLOCKED: FollowPath.Result.PATIENCE_EXCEEDED,
    Failure.STUCK: FollowPath.Result.FAILED_TO_MAKE_PROGRESS,
    Failure.LOST: FollowPath.Result.TF_ERROR,
}
"""Nav2's error code for each failure of a drive along a given path."""

TELEOP_CODES = {
    Failure.LATE: AssistedTeleop.Result.TIMEOUT,
    Failure.LOST: AssistedTeleop.Result.TF_ERROR,
}
"""Nav2's error code for each failure of a drive by hand."""


def pose_message(pose: Pose2D, frame: str, stamp: TimeMsg) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.pose.position.x, message.pose.position.y = pose.x, pose.y
    turn = message.pose.orientation
    turn.z, turn.w = math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)
    return message


def path_message(path: Array, end: Pose2D, frame: str, stamp: TimeMsg) -> Path:
    """Make a Path: each pose heads along the path, the last pose as the goal does."""
    message = Path()
    message.header.frame_id, message.header.stamp = frame, stamp
    for (x, y), (next_x, next_y) in pairwise(path):
        yaw = math.atan2(next_y - y, next_x - x)
        message.poses.append(pose_message(Pose2D(float(x), float(y), yaw), frame, stamp))
    message.poses.append(pose_message(end, frame, stamp))
    return message
