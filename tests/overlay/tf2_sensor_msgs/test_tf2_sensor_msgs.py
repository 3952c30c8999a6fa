"""tf2_sensor_msgs: clouds in another frame."""

from __future__ import annotations

from copy import deepcopy
from math import sqrt

import numpy as np
import pytest
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from numpy.testing import assert_allclose
from sensor_msgs.msg import PointCloud2, PointField
from sensor_msgs_py.point_cloud2 import create_cloud, dtype_from_fields, read_points
from std_msgs.msg import Header
from tf2_sensor_msgs import transform_points
from tf2_sensor_msgs.tf2_sensor_msgs import do_transform_cloud

QUARTER_TURN = Transform(
    translation=Vector3(x=10.0),
    rotation=Quaternion(z=sqrt(0.5), w=sqrt(0.5)),  # about z
)
STAMPED = TransformStamped(header=Header(frame_id='map'), child_frame_id='lidar', transform=QUARTER_TURN)


@pytest.fixture
def cloud() -> PointCloud2:
    float32, uint16 = PointField.FLOAT32, PointField.UINT16
    fields = [PointField(name=name, offset=4 * i, datatype=float32, count=1) for i, name in enumerate('xyz')]
    fields.append(PointField(name='ring', offset=12, datatype=uint16, count=1))
    points = np.zeros((2, 3), dtype=dtype_from_fields(fields, 16))
    points['x'], points['y'], points['ring'] = [[1, 2, np.nan], [4, 5, 6]], 7, [[1, 2, 3], [4, 5, 6]]
    return create_cloud(Header(frame_id='lidar'), fields, points, step=16)


def test_points_are_turned_then_moved() -> None:
    assert_allclose(transform_points([[1, 0, 5], [0, 1, 5]], STAMPED), [[10, 1, 5], [9, 0, 5]], atol=1e-12)


def test_a_cloud_keeps_its_shape_and_its_other_fields(cloud: PointCloud2) -> None:
    before = deepcopy(cloud)
    result = do_transform_cloud(cloud, STAMPED)
    assert cloud == before
    assert (result.header.frame_id, result.height, result.width, result.point_step) == ('map', 3, 2, 16)
    points = read_points(result, reshape_organized_cloud=True)
    assert_allclose(points['x'], np.array([[3, 3, np.nan], [3, 3, 3]]), atol=1e-5)
    assert_allclose(points['y'], np.array([[1, 2, np.nan], [4, 5, 6]]), atol=1e-5)
    assert points['ring'].tolist() == [[1, 2, 3], [4, 5, 6]]


def test_a_plain_transform_leaves_the_header_alone(cloud: PointCloud2) -> None:
    assert do_transform_cloud(cloud, QUARTER_TURN).header == cloud.header


def test_a_buffer_transforms_clouds(cloud: PointCloud2) -> None:
    buffer = tf2_ros.Buffer()
    buffer.set_transform_static(STAMPED, 'test')
    assert buffer.transform(cloud, 'map').header.frame_id == 'map'


def test_a_cloud_without_places_is_refused() -> None:
    ring = PointField(name='ring', offset=0, datatype=PointField.UINT16, count=1)
    with pytest.raises(AssertionError, match='are no fields of the cloud'):
        do_transform_cloud(create_cloud(Header(), [ring], [(1,)]), STAMPED)
