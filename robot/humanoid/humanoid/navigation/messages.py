"""The base's poses as ROS messages."""

from __future__ import annotations

import math

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import Pose, PoseStamped
from nav_msgs.msg import Odometry

from humanoid.navigation.base import Base, Pose2D, yaw_of
from humanoid.navigation.goal_check import FRAME


def target_of(pose: Pose) -> Pose2D:
    turn = pose.orientation
    return Pose2D(pose.position.x, pose.position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))


def stamped(pose: Pose2D, stamp: TimeMsg) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = FRAME
    message.header.stamp = stamp
    _fill(message.pose, pose)
    return message


def odometry(base: Base, stamp: TimeMsg) -> Odometry:
    """Velocities in the base's own frame, as nav_msgs/Odometry wants them; covariance is left at zero."""
    message = Odometry()
    message.header.frame_id = FRAME
    message.header.stamp = stamp
    message.child_frame_id = 'base_link'
    _fill(message.pose.pose, base.pose)
    message.twist.twist.linear.x = base.velocity.x
    message.twist.twist.linear.y = base.velocity.y
    message.twist.twist.angular.z = base.velocity.yaw
    return message


def _fill(message: Pose, pose: Pose2D) -> None:
    message.position.x, message.position.y = pose.x, pose.y
    message.orientation.z, message.orientation.w = math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)
