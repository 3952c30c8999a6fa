"""Functions that transform messages of geometry_msgs, registered with tf2_ros.

No function changes its arguments. Results have the transform's header: the target frame and the transform's
time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

from geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    TransformStamped,
    Vector3,
    Vector3Stamped,
)
from tf2_ros import ConvertRegistration, TransformRegistration

from goalwire.transforms.rigid import Rigid, normalize, rotate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

T = TypeVar('T')


def do_transform_point(point: PointStamped, transform: TransformStamped) -> PointStamped:
    """Return a point in the transform's target frame."""
    x, y, z = _rigid(transform).apply((point.point.x, point.point.y, point.point.z))
    return PointStamped(header=transform.header, point=Point(x=x, y=y, z=z))


def do_transform_vector3(vector3: Vector3Stamped, transform: TransformStamped) -> Vector3Stamped:
    """Return a vector in the transform's target frame: rotated, not translated."""
    vector = vector3.vector
    x, y, z = rotate(_rigid(transform).rotation, (vector.x, vector.y, vector.z))
    return Vector3Stamped(header=transform.header, vector=Vector3(x=x, y=y, z=z))


def do_transform_pose(pose: Pose, transform: TransformStamped) -> Pose:
    """Return a pose in the transform's target frame; its orientation has w >= 0."""
    position, orientation = pose.position, pose.orientation
    quaternion = normalize((orientation.x, orientation.y, orientation.z, orientation.w))
    inner = Rigid((position.x, position.y, position.z), quaternion)
    (x, y, z), (qx, qy, qz, qw) = _rigid(transform).after(inner)
    sign = -1.0 if qw < 0 else 1.0
    return Pose(
        position=Point(x=x, y=y, z=z),
        orientation=Quaternion(x=sign * qx, y=sign * qy, z=sign * qz, w=sign * qw),
    )


def do_transform_pose_stamped(pose: PoseStamped, transform: TransformStamped) -> PoseStamped:
    """Return a stamped pose in the transform's target frame."""
    return PoseStamped(header=transform.header, pose=do_transform_pose(pose.pose, transform))


def do_transform_pose_with_covariance_stamped(
    pose: PoseWithCovarianceStamped, transform: TransformStamped
) -> PoseWithCovarianceStamped:
    """Return a pose and its covariance in the transform's target frame."""
    return PoseWithCovarianceStamped(
        header=transform.header,
        pose=PoseWithCovariance(
            pose=do_transform_pose(pose.pose.pose, transform),
            covariance=transform_covariance(pose.pose.covariance, transform),
        ),
    )


def transform_covariance(
    cov_in: Sequence[float] | NDArray[np.float64], transform: TransformStamped
) -> NDArray[np.float64]:
    """Return a covariance of (x, y, z, rotations about x, y, z), 36 numbers by rows, in the target frame."""
    import numpy as np

    rotation = _rigid(transform).rotation
    axes = [rotate(rotation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    both = np.kron(np.eye(2), np.array(axes).T)  # the same rotation for positions and angles
    turned: NDArray[np.float64] = (both @ np.reshape(cov_in, (6, 6)) @ both.T).reshape(36)
    return turned


def to_msg_msg(msg: T) -> T:
    """Return the message itself, since it needs no conversion to a message."""
    return msg


def from_msg_msg(msg: T) -> T:
    """Return the message itself, since the target type is a message."""
    return msg


def _rigid(transform: TransformStamped) -> Rigid:
    translation, rotation = transform.transform.translation, transform.transform.rotation
    return Rigid(
        (translation.x, translation.y, translation.z),
        normalize((rotation.x, rotation.y, rotation.z, rotation.w)),
    )


def _register() -> None:
    transforms, conversions = TransformRegistration(), ConvertRegistration()
    transforms.add(PointStamped, do_transform_point)
    transforms.add(Vector3Stamped, do_transform_vector3)
    transforms.add(PoseStamped, do_transform_pose_stamped)
    transforms.add(PoseWithCovarianceStamped, do_transform_pose_with_covariance_stamped)
    for message_type in (PointStamped, Vector3Stamped, PoseStamped, PoseWithCovarianceStamped):
        conversions.add_to_msg(message_type, to_msg_msg)
        conversions.add_from_msg(message_type, from_msg_msg)


_register()
