"""4 x 4 matrices that transform points (x, y, z, 1). Returned points have four numbers; the last is 1."""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import ArrayLike

from tf_transformations.euler import euler_from_matrix, euler_matrix
from tf_transformations.quaternions import (
    angle_and_axis,
    quaternion_about_axis,
    quaternion_from_matrix,
    quaternion_matrix,
)
from tf_transformations.vectors import Array, floats, unit_vector

_SAME = 1e-8


def identity_matrix() -> Array:
    """Return the matrix that leaves all points unchanged."""
    return np.identity(4)


def translation_matrix(direction: ArrayLike) -> Array:
    """Return the matrix that translates points by a vector."""
    return _affine(np.identity(3), floats(direction)[:3])


def translation_from_matrix(matrix: ArrayLike) -> Array:
    """Return the translation of a matrix: the point to which it takes the origin."""
    return floats(matrix)[:3, 3].copy()


def rotation_matrix(angle: float, direction: ArrayLike, point: ArrayLike | None = None) -> Array:
    """Return the matrix that rotates by an angle about an axis through a point, by default the origin."""
    return _about(quaternion_matrix(quaternion_about_axis(angle, direction))[:3, :3], point)


def rotation_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array]:
    """Return a rotation matrix's angle and axis, and a point on the axis."""
    m = floats(matrix)
    angle, axis = angle_and_axis(quaternion_from_matrix(m))
    return angle, axis, _fixed_point(m)


def reflection_matrix(point: ArrayLike, normal: ArrayLike) -> Array:
    """Return the matrix that reflects points at the plane with this point and normal."""
    return scale_matrix(-1.0, point, normal)


def reflection_from_matrix(matrix: ArrayLike) -> tuple[Array, Array]:
    """Return a point of a reflection's plane, and its normal. Raises ValueError for any other matrix."""
    factor, point, normal = scale_from_matrix(matrix)
    if normal is None or abs(factor + 1) > _SAME:
        raise ValueError('the matrix is not a reflection')
    return point, normal


def scale_matrix(factor: float, origin: ArrayLike | None = None, direction: ArrayLike | None = None) -> Array:
    """Return the matrix that scales by a factor around a point, in one direction or in all directions."""
    if direction is None:
        return _about(factor * np.identity(3), origin)
    unit = unit_vector(floats(direction)[:3])
    return _about(np.identity(3) - (1 - factor) * np.outer(unit, unit), origin)


def scale_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array | None]:
    """Return a scaling's factor, fixed point and direction (None: all); raises ValueError for others."""
    m = floats(matrix)
    inner = m[:3, :3]
    uniform = float(np.trace(inner)) / 3
    if np.allclose(inner, uniform * np.identity(3)):
        return uniform, _fixed_point(m), None
    change = np.identity(3) - inner  # for one direction d: (1 - factor) d dᵀ
    unit = unit_vector(change[np.argmax(np.sum(change**2, axis=1))])
    factor = 1 - float(np.trace(change))
    if not np.allclose(change, (1 - factor) * np.outer(unit, unit)):
        raise ValueError('the matrix is not a scaling by one factor')
    return factor, _fixed_point(m), unit


def concatenate_matrices(*matrices: ArrayLike) -> Array:
    """Return the product of matrices: the last one is applied first."""
    return reduce(np.dot, (floats(matrix) for matrix in matrices), np.identity(4))


def inverse_matrix(matrix: ArrayLike) -> Array:
    """Return the inverse of a matrix. Raises numpy.linalg.LinAlgError if the matrix has no inverse."""
    return floats(np.linalg.inv(floats(matrix)))


def is_same_transform(matrix0: ArrayLike, matrix1: ArrayLike) -> bool:
    """Return whether two matrices transform all points equally."""
    first, second = floats(matrix0), floats(matrix1)
    return bool(np.allclose(first / first[3, 3], second / second[3, 3]))


def compose_matrix(
    scale: ArrayLike | None = None,
    shear: ArrayLike | None = None,
    angles: ArrayLike | None = None,
    translate: ArrayLike | None = None,
    perspective: ArrayLike | None = None,
) -> Array:
    """Return the matrix that scales, shears (xy, xz, yz), rotates (sxyz), translates, then projects."""
    matrix = np.identity(4)
    if perspective is not None:
        matrix[3, :] = floats(perspective)[:4]
    if translate is not None:
        matrix = matrix @ translation_matrix(translate)
    if angles is not None:
        ai, aj, ak = floats(angles)
        matrix = matrix @ euler_matrix(ai, aj, ak)
    if shear is not None:
        slanted = np.identity(4)
        slanted[0, 1], slanted[0, 2], slanted[1, 2] = floats(shear)
        matrix = matrix @ slanted
    if scale is not None:
        matrix = matrix @ np.diag([*floats(scale)[:3], 1.0])
    return floats(matrix / matrix[3, 3])


def decompose_matrix(matrix: ArrayLike) -> tuple[Array, list[float], list[float], Array, Array]:
    """Return scale, shear, angles, translation and perspective: the arguments of compose_matrix.

    Raises ValueError for a singular matrix.
    """
    m = floats(matrix) / floats(matrix)[3, 3]
    affine = m.copy()
    affine[3, :] = (0, 0, 0, 1)
    if abs(np.linalg.det(affine)) < np.finfo(np.float64).eps:
        raise ValueError('Matrix is singular')
    turn, upper = np.linalg.qr(affine[:3, :3])
    signs = np.sign(np.diag(upper))
    turn, upper = turn * signs, signs[:, None] * upper  # choose scale factors above 0
    if np.linalg.det(turn) < 0:
        turn, upper = -turn, -upper
    scale = np.diag(upper).copy()
    shear = [float(upper[0, 1] / scale[1]), float(upper[0, 2] / scale[2]), float(upper[1, 2] / scale[2])]
    perspective = m[3] @ np.linalg.inv(affine)
    return scale, shear, list(euler_from_matrix(turn)), m[:3, 3].copy(), floats(perspective)


def superimposition_matrix(v0: ArrayLike, v1: ArrayLike, scaling: bool = False, usesvd: bool = True) -> Array:
    """Return the matrix that best rotates and translates points `v0` to `v1`, of shape (3, N) (Kabsch, 1976).

    With `scaling` the matrix scales, too. `usesvd` has no effect.
    """
    first, second = floats(v0)[:3], floats(v1)[:3]
    centre, goal = first.mean(axis=1), second.mean(axis=1)
    first, second = first - centre[:, None], second - goal[:, None]
    left, _, right = np.linalg.svd(second @ first.T)
    handed = np.diag((1.0, 1.0, np.linalg.det(left @ right)))
    turn = left @ handed @ right
    if scaling:
        turn = turn * np.sqrt(np.sum(second**2) / np.sum(first**2))
    return _affine(turn, goal - turn @ centre)


def _affine(inner: Array, translation: Array) -> Array:
    matrix = np.identity(4)
    matrix[:3, :3], matrix[:3, 3] = inner, translation
    return matrix


def _about(inner: Array, point: ArrayLike | None) -> Array:
    centre = np.zeros(3) if point is None else floats(point)[:3]
    return _affine(inner, centre - inner @ centre)


def _fixed_point(matrix: Array) -> Array:
    point = np.linalg.lstsq(np.identity(3) - matrix[:3, :3], matrix[:3, 3], rcond=None)[0]
    return floats((*point, 1.0))
