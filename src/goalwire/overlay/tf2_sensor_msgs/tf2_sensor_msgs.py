"""The function that transforms sensor_msgs/PointCloud2, registered with tf2_ros."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from geometry_msgs.msg import Transform, TransformStamped
from sensor_msgs.msg import PointCloud2
from tf2_ros import ConvertRegistration, TransformRegistration

from goalwire.transforms.rigid import normalize, rotate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Points: TypeAlias = NDArray[np.floating]


def transform_points(point_cloud: ArrayLike, transform: Transform | TransformStamped) -> Points:
    """Return points, an array of shape (N, 3), in the transform's target frame."""
    import numpy as np

    motion = transform.transform if isinstance(transform, TransformStamped) else transform
    rotation, translation = motion.rotation, motion.translation
    unit = normalize((rotation.x, rotation.y, rotation.z, rotation.w))
    axes = [rotate(unit, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    moved: Points = np.asarray(point_cloud) @ np.array(axes) + (translation.x, translation.y, translation.z)
    return moved


def do_transform_cloud(cloud: PointCloud2, transform: Transform | TransformStamped) -> PointCloud2:
    """Return the cloud in the transform's target frame; fields other than x, y and z are copied.

    The given cloud is not changed. The result has the transform's header, or the cloud's header for a plain
    Transform, which has no header. Raises AssertionError for a cloud without x, y and z.
    """
    import numpy as np
    from numpy.lib.recfunctions import structured_to_unstructured
    from sensor_msgs_py.point_cloud2 import create_cloud, read_points

    header = transform.header if isinstance(transform, TransformStamped) else cloud.header
    places = read_points(cloud, field_names=('x', 'y', 'z'))
    moved = transform_points(structured_to_unstructured(places, dtype=np.float64), transform)
    points = read_points(cloud, reshape_organized_cloud=True).copy()
    for name, values in zip('xyz', moved.T, strict=True):
        points[name] = values.reshape(points.shape)
    result = create_cloud(header, cloud.fields, points, cloud.point_step)
    result.is_dense = cloud.is_dense
    return result


def to_msg_msg(msg: PointCloud2) -> PointCloud2:
    """Return the message itself, since it needs no conversion to a message."""
    return msg


def from_msg_msg(msg: PointCloud2) -> PointCloud2:
    """Return the message itself, since the target type is a message."""
    return msg


TransformRegistration().add(PointCloud2, do_transform_cloud)
ConvertRegistration().add_to_msg(PointCloud2, to_msg_msg)
ConvertRegistration().add_from_msg(PointCloud2, from_msg_msg)
