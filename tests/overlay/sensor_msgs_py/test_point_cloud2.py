"""Point clouds as numpy arrays."""

from __future__ import annotations

import struct
from array import array

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2, PointField
from sensor_msgs_py.point_cloud2 import (
    create_cloud,
    create_cloud_xyz32,
    dtype_from_fields,
    read_points,
    read_points_list,
    read_points_numpy,
)
from std_msgs.msg import Header

HEADER = Header(frame_id='lidar')
NAN = float('nan')
POINTS = [(1.0, 2.0, 3.0), (4.0, NAN, 6.0), (7.0, 8.0, 9.0)]


def field(name: str, offset: int, datatype: int = PointField.FLOAT32, count: int = 1) -> PointField:
    return PointField(name=name, offset=offset, datatype=datatype, count=count)


MIXED = [field('x', 0), field('ring', 4, PointField.UINT16), field('time', 8, PointField.FLOAT64)]


def test_a_cloud_of_xyz_has_the_layout_of_ros() -> None:
    cloud = create_cloud_xyz32(HEADER, POINTS)
    assert (cloud.header, cloud.height, cloud.width) == (HEADER, 1, 3)
    assert (cloud.point_step, cloud.row_step, cloud.is_dense, cloud.is_bigendian) == (12, 36, False, False)
    assert [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields] == [
        ('x', 0, 7, 1),
        ('y', 4, 7, 1),
        ('z', 8, 7, 1),
    ]
    assert bytes(cloud.data[:12]) == struct.pack('<3f', 1.0, 2.0, 3.0)


@pytest.mark.parametrize('points', [POINTS, iter(POINTS), np.array(POINTS), np.array(POINTS, np.float32)])
def test_points_come_back_as_they_were_given(points: object) -> None:
    cloud = create_cloud_xyz32(HEADER, points)  # type: ignore[arg-type]
    again = deserialize_message(serialize_message(cloud), PointCloud2)
    np.testing.assert_array_equal(read_points_numpy(again), np.array(POINTS, np.float32))


def test_fields_of_several_types_are_records() -> None:
    cloud = create_cloud(HEADER, MIXED, [(1.5, 7, 0.25), (2.5, 8, 0.5)])
    assert cloud.point_step == 16
    points = read_points(cloud)
    assert points.dtype.names == ('x', 'ring', 'time')
    assert points.tolist() == [(1.5, 7, 0.25), (2.5, 8, 0.5)]
    assert read_points(create_cloud(HEADER, MIXED, points)).tolist() == points.tolist()


def test_fields_are_selected_by_name() -> None:
    cloud = create_cloud(HEADER, MIXED, [(1.5, 7, 0.25)])
    assert read_points(cloud, ['time', 'x']).tolist() == [(0.25, 1.5)]
    assert read_points_numpy(cloud, ['time']).tolist() == [[0.25]]
    with pytest.raises(AssertionError, match=r"\['y'\] are no fields of the cloud: it has \['x', "):
        read_points(cloud, ['x', 'y'])


def test_points_with_a_nan_are_skipped_unless_the_cloud_is_dense() -> None:
    cloud = create_cloud_xyz32(HEADER, POINTS)
    assert read_points(cloud, skip_nans=True).tolist() == [POINTS[0], POINTS[2]]
    assert len(read_points(cloud, ['x', 'z'], skip_nans=True)) == 3
    cloud.is_dense = True
    assert len(read_points(cloud, skip_nans=True)) == 3


def test_points_are_selected_by_index() -> None:
    cloud = create_cloud_xyz32(HEADER, POINTS)
    for uvs in ([2, 0], iter([2, 0]), np.array([2, 0])):
        assert read_points(cloud, uvs=uvs).tolist() == [POINTS[2], POINTS[0]]


def test_points_are_listed_as_named_tuples() -> None:
    (point,) = read_points_list(create_cloud(HEADER, MIXED, [(1.5, 7, 0.25)]), ['ring', 'x'])
    assert point == (7, 1.5)
    assert point._fields == ('ring', 'x')  # type: ignore[attr-defined]


def test_an_organized_cloud_has_the_shape_that_ros_2_gives_it() -> None:
    grid = np.arange(24, dtype=np.float32).reshape(2, 4, 3)
    cloud = create_cloud_xyz32(HEADER, grid)
    assert (cloud.width, cloud.height, cloud.row_step) == (2, 4, 24)
    assert cloud.data.tobytes() == grid.tobytes()
    np.testing.assert_array_equal(read_points_numpy(cloud, reshape_organized_cloud=True), grid)
    assert read_points(cloud).shape == (8,)


def test_padded_rows_are_read_as_they_lie() -> None:
    cloud = create_cloud_xyz32(HEADER, np.arange(12, dtype=np.float32).reshape(2, 2, 3))
    rows = [cloud.data[:24], cloud.data[24:]]
    cloud.row_step = 32
    cloud.data = rows[0] + array('B', bytes(8)) + rows[1] + array('B', bytes(8))
    assert read_points_numpy(cloud).reshape(-1).tolist() == list(range(12))


def test_bytes_of_the_other_order_are_swapped_and_the_message_is_left_alone() -> None:
    cloud = create_cloud(HEADER, MIXED, [(0.0, 0, 0.0)])
    cloud.is_bigendian = True
    cloud.data = array('B', struct.pack('>fH2xd', 1.5, 7, 0.25))
    for _ in range(2):
        assert read_points(cloud).tolist() == [(1.5, 7, 0.25)]


def test_a_view_shows_the_clouds_own_data() -> None:
    cloud = create_cloud_xyz32(HEADER, POINTS)
    read_points(cloud)['x'] = 5.0
    assert read_points(cloud)['x'].tolist() == [5.0, 5.0, 5.0]


def test_a_point_may_be_wider_than_its_fields() -> None:
    cloud = create_cloud_xyz32(HEADER, POINTS, step=16)
    assert (cloud.point_step, cloud.row_step, len(cloud.data)) == (16, 48, 48)
    assert read_points(cloud).tolist()[0] == POINTS[0]


def test_a_field_of_several_values_becomes_several() -> None:
    dtype = dtype_from_fields([field('rgb', 0, PointField.UINT8, 3), field('', 4)])
    assert dtype.names == ('rgb_0', 'rgb_1', 'rgb_2', 'unnamed_field_1')
    assert [dtype.fields[name][1] for name in dtype.names] == [0, 1, 2, 4]  # type: ignore[index]
    assert dtype_from_fields([field('x', 0)], point_step=32).itemsize == 32


@pytest.mark.parametrize(
    ('fields', 'text'),
    [
        ([field('x', 0), field('x', 4)], 'Duplicate field names'),
        ([field('x', 0, count=0)], 'count = 0'),
        ([field('x', 0, datatype=9)], 'no datatype 9'),
    ],
)
def test_fields_that_make_no_sense_are_refused(fields: list[PointField], text: str) -> None:
    with pytest.raises(AssertionError, match=text):
        dtype_from_fields(fields)


def test_what_does_not_fit_the_fields_is_refused() -> None:
    with pytest.raises(AssertionError, match='All fields need to have the same datatype'):
        create_cloud(HEADER, MIXED, np.zeros((2, 3)))
    with pytest.raises(AssertionError, match='the points are records of'):
        create_cloud(HEADER, MIXED, np.zeros(2, dtype=[('x', np.float32)]))
    with pytest.raises(AssertionError, match='Too many dimensions'):
        create_cloud_xyz32(HEADER, np.zeros((2, 2, 2, 3)))
    with pytest.raises(AssertionError, match='All fields need to have the same datatype'):
        read_points_numpy(create_cloud(HEADER, MIXED, [(1.5, 7, 0.25)]))
    with pytest.raises(AssertionError, match='PointCloud2'):
        read_points(HEADER)  # type: ignore[arg-type]


def test_a_cloud_without_points_has_none() -> None:
    cloud = create_cloud_xyz32(HEADER, [])
    assert (cloud.width, len(cloud.data)) == (0, 0)
    assert read_points_list(cloud) == []
