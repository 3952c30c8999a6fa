"""Layers of the 3D view that draw a point cloud, a camera, and poses with their uncertainty."""

from __future__ import annotations

import math
from base64 import b64decode
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, PointCloud2, PointField
from sensor_msgs_py.point_cloud2 import create_cloud
from std_msgs.msg import Header

from goalwire.apps.console.state.layers import Drawing
from goalwire.apps.console.state.sensed_layers import (
    MOST_CLOUD_POINTS,
    draw_camera,
    draw_cloud,
    draw_pose,
)
from goalwire.errors import RemoteError

XYZ = [
    PointField(name=name, offset=4 * n, datatype=PointField.FLOAT32, count=1) for n, name in enumerate('xyz')
]


def cloud(points: Any, fields: list[PointField] = XYZ) -> PointCloud2:
    made: PointCloud2 = create_cloud(Header(frame_id='/camera'), fields, points)
    return made


def spots(drawing: Drawing) -> Any:
    [shape] = drawing.shapes['camera']
    return np.frombuffer(b64decode(shape['spots']), '<f4').reshape(-1, 3)


def colours(drawing: Drawing) -> Any:
    [shape] = drawing.shapes['camera']
    return np.frombuffer(b64decode(shape['colours']), np.uint8).reshape(-1, 3)


# -- point clouds --------------------------------------------------------------------------------------------


def test_a_cloud_is_drawn_point_for_point_and_without_nan() -> None:
    drawing = draw_cloud(cloud([(1.0, 2.0, 3.0), (math.nan, 0.0, 0.0), (4.0, 5.0, 6.0)]))
    assert spots(drawing).tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert drawing.note == '2 points'
    low, high = colours(drawing).astype(int)
    assert low[2] > low[0], 'low is blue'
    assert high[0] > high[2], 'and high is red'


def test_a_large_cloud_is_thinned_out() -> None:
    drawing = draw_cloud(cloud(np.arange(3.0 * 3 * MOST_CLOUD_POINTS).reshape(-1, 3)))
    assert len(spots(drawing)) == MOST_CLOUD_POINTS
    assert spots(drawing)[1].tolist() == [9.0, 10.0, 11.0]
    assert drawing.note == f'{MOST_CLOUD_POINTS} points, one of each 3'


def test_a_clouds_own_colours_are_kept() -> None:
    fields = [*XYZ, PointField(name='rgb', offset=12, datatype=PointField.UINT32, count=1)]
    drawing = draw_cloud(cloud([(0.0, 0.0, 0.0, 0x102030), (0.0, 0.0, 1.0, 0xFF0001)], fields))
    assert colours(drawing).tolist() == [[0x10, 0x20, 0x30], [0xFF, 0x00, 0x01]]


def test_doubles_in_big_endian_and_padded_rows_are_read() -> None:
    message = PointCloud2(width=1, height=2, point_step=24, row_step=32, is_bigendian=True)
    message.header.frame_id = 'camera'
    message.fields = [
        PointField(name=name, offset=8 * n, datatype=PointField.FLOAT64, count=1)
        for n, name in enumerate('xyz')
    ]
    rows = [np.array(row, '>f8').tobytes() + bytes(8) for row in ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))]
    message.data = b''.join(rows)
    assert spots(draw_cloud(message)).tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def test_an_empty_cloud_is_drawn_as_nothing() -> None:
    assert draw_cloud(cloud([])).note == '0 points'
    assert draw_cloud(cloud([(math.nan, 0.0, 0.0)])).note == '0 points'


@pytest.mark.parametrize(
    ('change', 'problem'),
    [
        ({'fields': XYZ[:2]}, 'no fields x, y and z'),
        ({'width': 9}, 'should have 9 points of 12 bytes, but has 12 bytes'),
        ({'row_step': 1}, 'should have'),
        ({'point_step': 8, 'row_step': 8}, "field 'z' lies outside"),
        ({'point_step': 0, 'row_step': 0, 'data': b''}, '1 points of 0 bytes'),
    ],
    ids=lambda given: ' '.join(given) if isinstance(given, dict) else '',
)
def test_a_cloud_that_is_not_whole_is_refused(change: dict[str, Any], problem: str) -> None:
    message = cloud([(1.0, 2.0, 3.0)])
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(RemoteError, match=problem):
        draw_cloud(message)


# -- cameras and poses ---------------------------------------------------------------------------------------


def test_a_camera_is_drawn_as_what_it_sees() -> None:
    message = CameraInfo(width=200, height=100, k=[100.0, 0.0, 100.0, 0.0, 100.0, 50.0, 0.0, 0.0, 1.0])
    message.header.frame_id = 'optical'
    [shape] = draw_camera(message).shapes['optical']
    ends = np.array(shape['spots']).reshape(-1, 2, 3)
    assert len(ends) == 8
    corner = ends[0][1]
    assert corner / corner[2] == pytest.approx([-1.0, -0.5, 1.0]), '45 degrees to the left, 27 up'
    with pytest.raises(RemoteError, match='not calibrated'):
        draw_camera(CameraInfo(width=200, height=100))


def test_a_pose_is_an_arrow_and_its_uncertainty_an_ellipse() -> None:
    message = PoseWithCovarianceStamped()
    message.header.frame_id = 'map'
    message.pose.pose.position.x = 3.0
    message.pose.covariance[0], message.pose.covariance[7], message.pose.covariance[35] = 0.25, 0.01, 0.0004
    drawing = draw_pose(message)
    arrow, ellipse = drawing.shapes['map']
    assert arrow['pose'][:3] == [3.0, 0.0, 0.0]
    rim = np.array(ellipse['spots']).reshape(-1, 3)
    assert (rim[:, 0].min(), rim[:, 0].max()) == pytest.approx((2.0, 4.0), abs=0.01)
    assert rim[:, 1].max() == pytest.approx(0.2, abs=0.01)
    assert drawing.note == '±1.00 m, ±2.3°'


def test_a_pose_without_covariance_is_an_arrow_alone() -> None:
    for message, note in ((Odometry(), 'without covariance'), (PoseStamped(), 'a pose')):
        drawing = draw_pose(message)
        assert len(drawing.shapes['']) == 1
        assert drawing.note == note
    broken = PoseStamped()
    broken.pose.position.x = math.nan
    with pytest.raises(RemoteError, match='not finite'):
        draw_pose(broken)
