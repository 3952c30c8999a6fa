"""The base's poses and motions as ROS messages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import Pose, PoseStamped, Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from humanoid.navigation.base import MobileBase, Placement, Pose2D, Velocity2D, yaw_of
from humanoid.navigation.goal_check import FRAME
from humanoid.urdf import orientation

BASE_LINK = 'base_link'
GRAVITY = 9.80665  # m/s²

# Variances of x, y, z and of the rotations about them: m² and rad², of velocities m²/s² and rad²/s².
POSE_VARIANCES = (1e-4, 1e-4, 1e-6, 1e-6, 1e-6, 1e-4)
TWIST_VARIANCES = (1e-4, 1e-4, 1e-6, 1e-6, 1e-6, 1e-4)
TURN_VARIANCES = (1e-6, 1e-6, 1e-4)
GYRO_VARIANCES = (1e-6, 1e-6, 1e-6)
PULL_VARIANCES = (1e-2, 1e-2, 1e-2)


def target_of(pose: Pose) -> Pose2D:
    turn = pose.orientation
    return Pose2D(pose.position.x, pose.position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))


def stamp_pose(pose: Pose2D, stamp: TimeMsg, prefix: str = '') -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = f'{prefix}{FRAME}'
    message.header.stamp = stamp
    _fill(message.pose, pose)
    return message


def odometry(
    base: MobileBase | Placement, pose: Pose2D, frame: str, stamp: TimeMsg, prefix: str = ''
) -> Odometry:
    """Make the Odometry: base_link's pose in `frame`, and base_link's velocity in its own frame."""
    message = Odometry()
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.child_frame_id = f'{prefix}{BASE_LINK}'
    _fill(message.pose.pose, pose)
    message.pose.pose.position.z = base.height
    x, y, z, w = orientation(*base.tilt, pose.yaw)
    message.pose.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    message.pose.covariance = _diagonal(POSE_VARIANCES)
    message.twist.twist.linear.x = base.velocity.x
    message.twist.twist.linear.y = base.velocity.y
    message.twist.twist.angular.z = base.velocity.yaw
    message.twist.covariance = _diagonal(TWIST_VARIANCES)
    return message


def transform(odometry: Odometry) -> TransformStamped:
    """Make the transform from odom to base_link, from an Odometry message."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    place = odometry.pose.pose.position
    message.transform.translation.x = place.x
    message.transform.translation.y = place.y
    message.transform.translation.z = place.z
    message.transform.rotation = odometry.pose.pose.orientation
    return message


def place_frame(frame: str, place: Pose2D, stamp: TimeMsg, child: str) -> TransformStamped:
    """Make the transform that places `child` in `frame`."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.transform.translation.x, message.transform.translation.y = place.x, place.y
    turn = message.transform.rotation
    turn.z, turn.w = math.sin(place.yaw / 2.0), math.cos(place.yaw / 2.0)
    return message


def imu(
    pose: Pose2D, before: Velocity2D, after: Velocity2D, elapsed: float, stamp: TimeMsg, prefix: str
) -> Imu:
    """Make the reading of an ideal inertial sensor in the pelvis, from two velocities `elapsed` s apart."""
    message = Imu()
    message.header.frame_id = f'{prefix}imu_link'
    message.header.stamp = stamp
    message.orientation.z, message.orientation.w = math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)
    message.orientation_covariance = _diagonal(TURN_VARIANCES)
    message.angular_velocity.z = after.yaw
    message.angular_velocity_covariance = _diagonal(GYRO_VARIANCES)
    if elapsed > 0.0:
        message.linear_acceleration.x = (after.x - before.x) / elapsed - after.yaw * after.y
        message.linear_acceleration.y = (after.y - before.y) / elapsed + after.yaw * after.x
    message.linear_acceleration.z = GRAVITY
    message.linear_acceleration_covariance = _diagonal(PULL_VARIANCES)
    return message


def _diagonal(variances: Iterable[float]) -> Sequence[float]:
    """Return a covariance matrix with these variances on its diagonal, row by row."""
    own = list(variances)
    size = len(own)
    return [own[row] if row == column else 0.0 for row in range(size) for column in range(size)]


def _fill(message: Pose, pose: Pose2D) -> None:
    message.position.x, message.position.y = pose.x, pose.y
    message.orientation.z, message.orientation.w = math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)
