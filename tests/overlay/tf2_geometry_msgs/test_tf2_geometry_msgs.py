"""Geometry taken from one frame to another."""

from __future__ import annotations

from copy import deepcopy
from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest
import tf2_geometry_msgs as geometry
from builtin_interfaces.msg import Time
from geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Vector3,
    Vector3Stamped,
)
from std_msgs.msg import Header
from tf2_ros import Buffer, TypeException

MAP = Header(frame_id='map', stamp=Time(sec=5))
ARM = Header(frame_id='arm', stamp=Time(sec=4))
QUARTER = Quaternion(x=0.0, y=0.0, z=sin(pi / 4), w=cos(pi / 4))
NEAR = 1e-12


@pytest.fixture
def transform() -> TransformStamped:
    """arm in map: at (10, 0, 1), turned a quarter about z."""
    return TransformStamped(
        header=MAP,
        child_frame_id='arm',
        transform=Transform(translation=Vector3(x=10.0, z=1.0), rotation=QUARTER),
    )


def xyz(value: Point | Vector3) -> tuple[float, float, float]:
    return value.x, value.y, value.z


def test_a_point_is_turned_and_moved(transform: TransformStamped) -> None:
    found = geometry.do_transform_point(PointStamped(header=ARM, point=Point(x=1.0, z=2.0)), transform)
    assert found.header == MAP
    assert xyz(found.point) == pytest.approx((10.0, 1.0, 3.0))


def test_a_vector_is_turned_and_the_transform_left_alone(transform: TransformStamped) -> None:
    before = deepcopy(transform)
    found = geometry.do_transform_vector3(Vector3Stamped(header=ARM, vector=Vector3(x=1.0, z=2.0)), transform)
    assert xyz(found.vector) == pytest.approx((0.0, 1.0, 2.0), abs=NEAR)
    assert transform == before


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_pose_is_turned_and_moved_and_has_w_positive(transform: TransformStamped, sign: float) -> None:
    orientation = Quaternion(x=0.0, y=0.0, z=sign * sin(pi / 8), w=sign * cos(pi / 8))
    pose = Pose(position=Point(y=1.0), orientation=orientation)
    found = geometry.do_transform_pose_stamped(PoseStamped(header=ARM, pose=pose), transform)
    assert found.header == MAP
    assert xyz(found.pose.position) == pytest.approx((9.0, 0.0, 1.0))
    turned = found.pose.orientation
    assert (turned.z, turned.w) == pytest.approx((sin(3 * pi / 8), cos(3 * pi / 8)))


def test_an_orientation_of_zeros_counts_as_none(transform: TransformStamped) -> None:
    pose = Pose(orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=0.0))
    found = geometry.do_transform_pose(pose, transform).orientation
    assert (found.z, found.w) == pytest.approx((QUARTER.z, QUARTER.w))


def test_a_covariance_gets_turned_axes(transform: TransformStamped) -> None:
    covariance = np.arange(36.0)
    found = geometry.transform_covariance(covariance, transform).reshape(6, 6)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            block = covariance.reshape(6, 6)[rows, columns]
            np.testing.assert_allclose(found[rows, columns], turn @ block @ turn.T, atol=NEAR)


def test_a_pose_with_covariance_is_taken_along(transform: TransformStamped) -> None:
    uncertain = PoseWithCovariance(
        pose=Pose(position=Point(x=1.0)), covariance=np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).reshape(36)
    )
    found = geometry.do_transform_pose_with_covariance_stamped(
        PoseWithCovarianceStamped(header=ARM, pose=uncertain), transform
    )
    assert xyz(found.pose.pose.position) == pytest.approx((10.0, 1.0, 1.0))
    diagonal = found.pose.covariance.reshape(6, 6).diagonal()
    np.testing.assert_allclose(diagonal, [2.0, 1.0, 3.0, 5.0, 4.0, 6.0])


@pytest.mark.parametrize(
    ('message', 'field'),
    [
        (PointStamped(header=ARM, point=Point(x=1.0)), 'point'),
        (PoseStamped(header=ARM, pose=Pose(position=Point(x=1.0))), 'pose.position'),
    ],
)
def test_a_buffer_transforms_registered_types(transform: TransformStamped, message: Any, field: str) -> None:
    buffer = Buffer()
    buffer.set_transform_static(transform, 'test')
    found = buffer.transform(message, 'map')
    assert found.header == Header(frame_id='map', stamp=ARM.stamp)
    value = found
    for name in field.split('.'):
        value = getattr(value, name)
    assert xyz(value) == pytest.approx((10.0, 1.0, 1.0))
    assert buffer.transform(message, 'map', new_type=type(message)) == found
    assert buffer.transform_full(message, 'map', Time(sec=9), 'map').header.stamp == Time(sec=9)


def test_a_type_that_nobody_registered_is_named() -> None:
    with pytest.raises(TypeException, match=r'TransformStamped.* is not loaded or supported'):
        Buffer().transform(TransformStamped(), 'map')
