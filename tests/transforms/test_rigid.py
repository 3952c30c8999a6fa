"""Rigid motions against numpy's matrices."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.transforms.rigid import (
    IDENTITY,
    NO_ROTATION,
    Quaternion,
    Rigid,
    canonical,
    normalize,
    rotate,
    slerp,
    yaw_of,
)

numbers = st.floats(-10, 10)
vectors = st.tuples(numbers, numbers, numbers)
parts = st.floats(-1, 1)
quaternions = (
    st.tuples(parts, parts, parts, parts).filter(lambda q: sum(x * x for x in q) > 0.01).map(normalize)
)
motions = st.builds(Rigid, vectors, quaternions)


def about_z(angle: float) -> Quaternion:
    return 0.0, 0.0, sin(angle / 2), cos(angle / 2)


def matrix(motion: Rigid) -> np.ndarray:
    """The 4x4 matrix of a motion, by the textbook's formula."""
    x, y, z, w = motion.rotation
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, 3] = motion.translation
    return result


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    assert rotate(about_z(pi / 2), (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))


@given(motions, vectors)
def test_points_go_where_the_matrix_takes_them(motion: Rigid, point: tuple[float, float, float]) -> None:
    expected = matrix(motion) @ [*point, 1.0]
    assert motion.apply(point) == pytest.approx(expected[:3], abs=1e-9)


@given(motions, motions)
def test_motions_multiply_like_matrices(second: Rigid, first: Rigid) -> None:
    np.testing.assert_allclose(matrix(second.after(first)), matrix(second) @ matrix(first), atol=1e-9)


@given(motions)
def test_the_inverse_undoes(motion: Rigid) -> None:
    np.testing.assert_allclose(matrix(motion.inverse().after(motion)), np.eye(4), atol=1e-9)


@given(quaternions)
def test_the_canonical_quaternion_is_the_same_rotation_either_way(rotation: Quaternion) -> None:
    x, y, z, w = rotation
    one, other = canonical(rotation), canonical((-x, -y, -z, -w))
    assert one == pytest.approx(other)
    np.testing.assert_allclose(
        matrix(Rigid((0.0, 0.0, 0.0), one)), matrix(Rigid((0.0, 0.0, 0.0), rotation)), atol=1e-9
    )


def test_the_canonical_quaternion_has_its_leading_part_positive() -> None:
    assert canonical((0.0, 0.0, 0.0, -1.0)) == NO_ROTATION
    assert canonical((0.0, 0.0, -1.0, 0.0)) == (0.0, 0.0, 1.0, 0.0)
    assert canonical((-0.9, 0.1, 0.1, 0.4))[0] > 0


def test_halfway_between_two_motions() -> None:
    other = Rigid((2.0, 4.0, 6.0), about_z(pi / 2))
    between = IDENTITY.towards(other, 0.5)
    assert between.translation == (1.0, 2.0, 3.0)
    assert between.rotation == pytest.approx(about_z(pi / 4))


def test_turning_takes_the_shorter_way_and_keeps_its_speed() -> None:
    x, y, z, w = about_z(pi / 2)
    for ratio in (0.0, 0.25, 0.5, 1.0):
        assert slerp(NO_ROTATION, (-x, -y, -z, -w), ratio) == pytest.approx(about_z(ratio * pi / 2))


@given(quaternions, st.floats(0, 1))
def test_between_a_rotation_and_itself_is_itself(rotation: Quaternion, ratio: float) -> None:
    assert slerp(rotation, rotation, ratio) == pytest.approx(rotation, abs=1e-9)
    x, y, z, w = rotation
    assert canonical(slerp(rotation, (-x, -y, -z, -w), ratio)) == pytest.approx(canonical(rotation), abs=1e-9)


def test_a_quaternion_of_length_zero_is_no_rotation() -> None:
    assert normalize((0.0, 0.0, 0.0, 0.0)) == NO_ROTATION


@given(quaternions)
def test_yaw_is_the_heading_of_the_x_axis(rotation: Quaternion) -> None:
    x, y, _ = rotate(rotation, (1.0, 0.0, 0.0))
    if hypot(x, y) > 0.01:  # an axis that points straight up has no heading
        assert cos(yaw_of(rotation) - atan2(y, x)) == pytest.approx(1.0, abs=1e-6)
