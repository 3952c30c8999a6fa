"""tf_transformations: what its functions promise of each other, and the values everybody knows."""

from __future__ import annotations

from itertools import product
from math import pi, sqrt

import numpy as np
import pytest
import tf_transformations as tf
from numpy.testing import assert_allclose

ALL_AXES = [
    frame + ''.join(axes)
    for frame, axes in product('sr', product('xyz', repeat=3))
    if axes[0] != axes[1] != axes[2]
]
POINT, AXIS = (0.3, -0.4, 0.7), (1.0, 2.0, -0.5)


def test_there_are_24_orders_of_axes() -> None:
    assert len(ALL_AXES) == 24


def test_yaw_is_a_turn_about_z_and_x_y_z_w_is_the_order() -> None:
    assert_allclose(tf.quaternion_from_euler(0, 0, pi / 2), (0, 0, sqrt(0.5), sqrt(0.5)), atol=1e-12)
    assert_allclose(tf.euler_from_quaternion((0, 0, 1, 0)), (0, 0, pi), atol=1e-12)


def test_fixed_axes_turn_roll_first_and_turning_axes_in_the_other_order() -> None:
    roll, pitch, yaw = 0.1, -0.5, 2.0
    turns = [tf.rotation_matrix(*turn) for turn in ((yaw, (0, 0, 1)), (pitch, (0, 1, 0)), (roll, (1, 0, 0)))]
    assert_allclose(tf.euler_matrix(roll, pitch, yaw), tf.concatenate_matrices(*turns), atol=1e-12)
    assert_allclose(
        tf.euler_matrix(yaw, pitch, roll, 'rzyx'), tf.euler_matrix(roll, pitch, yaw, 'sxyz'), atol=1e-12
    )


@pytest.mark.parametrize('axes', ALL_AXES)
def test_euler_angles_come_back(axes: str) -> None:
    quaternion = tf.quaternion_from_euler(-2.1, 0.8, 0.4, axes)
    angles = tf.euler_from_quaternion(quaternion, axes)
    assert_allclose(tf.euler_matrix(*angles, axes), tf.quaternion_matrix(quaternion), atol=1e-9)
    if len(set(axes[1:])) == 3:  # with one axis twice there are two answers
        assert_allclose(angles, (-2.1, 0.8, 0.4), atol=1e-9)


@pytest.mark.parametrize('axes', ALL_AXES)
@pytest.mark.parametrize('middle', [0.0, pi / 2, -pi / 2, pi])
def test_locked_euler_angles_stand_for_the_same_rotation(axes: str, middle: float) -> None:
    matrix = tf.euler_matrix(0.3, middle, -0.9, axes)
    assert_allclose(tf.euler_matrix(*tf.euler_from_matrix(matrix, axes), axes), matrix, atol=1e-6)


@pytest.mark.parametrize('axes', ['xyz', 'sxy', 'sxxy', 'txyz', 'sabc'])
def test_axes_that_are_none_are_refused(axes: str) -> None:
    with pytest.raises(ValueError, match=axes):
        tf.euler_matrix(0, 0, 0, axes)


def test_quaternions_multiply_as_their_matrices_do() -> None:
    first, second = tf.random_quaternion((0.1, 0.6, 0.3)), tf.random_quaternion((0.8, 0.2, 0.9))
    product_ = tf.quaternion_multiply(second, first)
    assert_allclose(
        tf.quaternion_matrix(product_), tf.quaternion_matrix(second) @ tf.quaternion_matrix(first), atol=1e-12
    )
    assert_allclose(tf.quaternion_multiply(first, tf.quaternion_inverse(first)), (0, 0, 0, 1), atol=1e-12)
    assert_allclose(tf.quaternion_conjugate(first), first * (-1, -1, -1, 1))


@pytest.mark.parametrize('rand', [(0.0, 0.0, 0.0), (0.3, 0.9, 0.5), (0.999, 0.1, 0.25), (1.0, 0.5, 0.75)])
def test_a_quaternion_comes_back_from_its_matrix_with_w_above_0(rand: tuple[float, float, float]) -> None:
    quaternion = tf.random_quaternion(rand)
    found = tf.quaternion_from_matrix(tf.quaternion_matrix(quaternion))
    assert found[3] >= 0
    assert abs(found @ quaternion) == pytest.approx(1)


def test_slerp_takes_the_shorter_way_at_constant_speed() -> None:
    start, end = tf.quaternion_from_euler(0, 0, 0), -tf.quaternion_from_euler(0, 0, 1.2)
    yaw = [tf.euler_from_quaternion(tf.quaternion_slerp(start, end, part))[2] for part in (0, 0.25, 0.5, 1)]
    assert_allclose(yaw, (0, 0.3, 0.6, 1.2), atol=1e-12)
    long_way = tf.quaternion_slerp(start, end, 0.5, shortestpath=False)
    assert tf.euler_from_quaternion(long_way)[2] == pytest.approx(0.6 - pi)


def test_a_rotation_about_an_axis_comes_back() -> None:
    matrix = tf.rotation_matrix(1.1, AXIS, POINT)
    assert_allclose(matrix @ (*POINT, 1), (*POINT, 1), atol=1e-12)
    angle, axis, point = tf.rotation_from_matrix(matrix)
    assert angle == pytest.approx(1.1)
    assert_allclose(axis, tf.unit_vector(AXIS), atol=1e-12)
    assert tf.is_same_transform(tf.rotation_matrix(angle, axis, point), matrix)


def test_reflections_and_scales_come_back() -> None:
    mirror = tf.reflection_matrix(POINT, AXIS)
    assert_allclose(mirror @ mirror, tf.identity_matrix(), atol=1e-12)
    assert tf.is_same_transform(tf.reflection_matrix(*tf.reflection_from_matrix(mirror)), mirror)
    for direction in (None, AXIS):
        scale = tf.scale_matrix(-1.7, POINT, direction)
        assert tf.is_same_transform(tf.scale_matrix(*tf.scale_from_matrix(scale)), scale)


def test_what_is_no_reflection_or_scale_is_refused() -> None:
    with pytest.raises(ValueError, match='not a reflection'):
        tf.reflection_from_matrix(tf.scale_matrix(2.0))
    with pytest.raises(ValueError, match='one factor'):
        tf.scale_from_matrix(np.diag((1.0, 2.0, 3.0, 1.0)))


def test_a_composed_matrix_comes_apart() -> None:
    parts = ((1.5, 0.5, 2.0), (0.1, -0.2, 0.3), (0.4, 0.5, -0.6), POINT, (0.0, 0.0, 0.0, 1.0))
    matrix = tf.compose_matrix(*parts)
    for found, given in zip(tf.decompose_matrix(matrix), parts, strict=True):
        assert_allclose(np.array(found), given, atol=1e-9)
    tilted = tf.compose_matrix(*parts[:4], perspective=(0.01, 0.02, 0.0, 1.0))
    assert tf.is_same_transform(tf.compose_matrix(*tf.decompose_matrix(tilted)), tilted)
    with pytest.raises(ValueError, match='singular'):
        tf.decompose_matrix(np.diag((1.0, 0.0, 1.0, 1.0)))


def test_points_are_laid_over_each_other() -> None:
    points = np.array(((0, 1, 0, 0.5), (0, 0, 2, 0.5), (0, 0, 0, 3.0)))
    motion = tf.concatenate_matrices(tf.translation_matrix(POINT), tf.rotation_matrix(2.0, AXIS))
    moved = (motion @ np.vstack((points, np.ones(4))))[:3]
    assert_allclose(tf.superimposition_matrix(points, moved), motion, atol=1e-9)
    scaled = tf.superimposition_matrix(points, 3 * points, scaling=True)
    assert_allclose(scaled, tf.scale_matrix(3.0), atol=1e-9)


def test_vectors() -> None:
    vectors = ((3.0, 4.0), (0.0, 2.0))
    assert tf.vector_norm((3, 4)) == 5
    assert_allclose(tf.vector_norm(vectors, axis=1), (5, 2))
    assert_allclose(tf.unit_vector(vectors, axis=1), ((0.6, 0.8), (0, 1)))
    out = np.empty(2)
    assert tf.unit_vector((0, 9), out=out) is out
    assert_allclose(out, (0, 1))
    assert tf.random_vector(3).shape == (3,)


def test_translations_and_inverses() -> None:
    matrix = tf.translation_matrix(POINT)
    assert_allclose(tf.translation_from_matrix(matrix), POINT)
    assert_allclose(tf.inverse_matrix(matrix), tf.translation_matrix(-np.array(POINT)))
    assert not tf.is_same_transform(matrix, tf.identity_matrix())
    assert np.linalg.det(tf.random_rotation_matrix()) == pytest.approx(1)


def test_the_table_of_axes_is_that_of_transformations_py() -> None:
    table = tf._AXES2TUPLE
    assert len(table) == 24
    known = {'sxyz': (0, 0, 0, 0), 'syxz': (1, 1, 0, 0), 'szyz': (2, 1, 1, 0), 'rzyx': (0, 0, 0, 1)}
    assert known.items() <= table.items()
    for axes in table:
        matrix = tf.euler_matrix(0.1, 0.2, 0.3, axes)
        angles = tf.euler_from_matrix(matrix, axes)
        assert_allclose(tf.euler_matrix(*angles, axes), matrix, atol=1e-12)
