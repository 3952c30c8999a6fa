"""Quaternions (x, y, z, w). A rotation is a unit quaternion; q and -q are the same rotation."""

from __future__ import annotations

from math import acos, atan2, cos, pi, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from tf_transformations.vectors import Array, floats, unit_vector

_NO_LENGTH = 4 * np.finfo(np.float64).eps
_ONE_DIRECTION = 1e-9


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Array:
    """Return the rotation by an angle about an axis, a vector that need not have length 1."""
    x, y, z = floats(axis)[:3]
    length = sqrt(x * x + y * y + z * z)
    if length < _NO_LENGTH:
        return floats((0.0, 0.0, 0.0, 1.0))
    part = sin(angle / 2) / length
    return floats((x * part, y * part, z * part, cos(angle / 2)))


def quaternion_matrix(quaternion: ArrayLike) -> Array:
    """Return the 4 x 4 matrix of a rotation; the quaternion need not have length 1."""
    x, y, z, w = floats(quaternion)
    matrix = np.identity(4)
    square = x * x + y * y + z * z + w * w
    if square < _NO_LENGTH:
        return matrix
    s = 2 / square
    matrix[:3, :3] = (
        (1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)),
    )
    return matrix


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Return the rotation of a matrix, with w >= 0.

    For a matrix that is not exactly a rotation, return the closest rotation (Bar-Itzhack, 2000).
    """
    m = floats(matrix)[:3, :3]
    symmetric = np.array(
        (
            (m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]),
            (m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]),
            (m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]),
            (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)),
        )
    )
    vectors = np.linalg.eigh(symmetric)[1]
    quaternion = floats(vectors[:, -1])  # the eigenvector with the largest eigenvalue
    return -quaternion if quaternion[3] < 0 else quaternion


def quaternion_multiply(quaternion1: ArrayLike, quaternion0: ArrayLike) -> Array:
    """Return the product of two quaternions: the rotation that applies `quaternion0`, then `quaternion1`."""
    x1, y1, z1, w1 = floats(quaternion1)
    x0, y0, z0, w0 = floats(quaternion0)
    return floats(
        (
            w1 * x0 + x1 * w0 + y1 * z0 - z1 * y0,
            w1 * y0 - x1 * z0 + y1 * w0 + z1 * x0,
            w1 * z0 + x1 * y0 - y1 * x0 + z1 * w0,
            w1 * w0 - x1 * x0 - y1 * y0 - z1 * z0,
        )
    )


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Return the conjugate of a quaternion: x, y and z change their sign."""
    return floats(quaternion) * floats((-1, -1, -1, 1))


def quaternion_inverse(quaternion: ArrayLike) -> Array:
    """Return the inverse quaternion, whose length is the reciprocal of the given quaternion's length."""
    return floats(quaternion_conjugate(quaternion) / np.sum(floats(quaternion) ** 2))


def quaternion_slerp(
    quat0: ArrayLike, quat1: ArrayLike, fraction: float, spin: int = 0, shortestpath: bool = True
) -> Array:
    """Return the rotation between two: `quat0` at fraction 0, `quat1` at 1, at constant angular speed.

    `spin` adds half turns to the path; if `shortestpath` is false, the path may be the longer of the two.
    """
    first, last = unit_vector(quat0), unit_vector(quat1)
    if fraction in (0, 1):
        return last if fraction else first
    cosine = float(first @ last)
    if cosine < 0 and shortestpath:
        cosine, last = -cosine, -last
    if abs(abs(cosine) - 1) < _ONE_DIRECTION:
        return first
    angle = acos(cosine) + spin * pi
    return floats((sin((1 - fraction) * angle) * first + sin(fraction * angle) * last) / sin(angle))


def random_quaternion(rand: ArrayLike | None = None) -> Array:
    """Return a uniformly random rotation; `rand` holds three random numbers from [0, 1) (Shoemake, 1992)."""
    a, b, c = np.random.default_rng().random(3) if rand is None else floats(rand)
    small, large = sqrt(1 - a), sqrt(a)
    first, second = 2 * pi * b, 2 * pi * c
    return floats((small * sin(first), small * cos(first), large * sin(second), large * cos(second)))


def random_rotation_matrix(rand: ArrayLike | None = None) -> Array:
    """Return the 4 x 4 matrix of a random rotation from random_quaternion()."""
    return quaternion_matrix(random_quaternion(rand))


def angle_and_axis(quaternion: ArrayLike) -> tuple[float, Array]:
    """Return the angle and the axis of a rotation. If the angle is 0, the axis is x."""
    values = floats(quaternion)
    length = sqrt(float(values[:3] @ values[:3]))
    if length < _NO_LENGTH:
        return 0.0, floats((1.0, 0.0, 0.0))
    return 2 * atan2(length, float(values[3])), values[:3] / length
