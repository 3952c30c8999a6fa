"""Euler angles: three rotations, about fixed axes ('s…') or about axes that rotate with the body ('r…')."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from itertools import pairwise, product
from math import atan2, hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tf_transformations.quaternions import quaternion_about_axis, quaternion_matrix, quaternion_multiply
from tf_transformations.vectors import Array, floats

_LOCKED = 4 * np.finfo(np.float64).eps


class _Axes(NamedTuple):
    """The axes of three rotations, in the order in which rotations about fixed axes are applied."""

    first: int
    second: int
    third: int
    turning: bool


def _axes_tuples() -> Iterator[tuple[str, tuple[int, int, int, int]]]:
    """Yield each name of a sequence of axes, with its first axis, parity, repetition and frame."""
    for letters in product('xyz', repeat=3):
        if letters[0] == letters[1] or letters[1] == letters[2]:
            continue
        first, second = ('xyz'.index(letter) for letter in letters[:2])
        numbers = first, int((second - first) % 3 != 1), int(letters[0] == letters[2])
        yield 's' + ''.join(letters), (*numbers, 0)
        yield 'r' + ''.join(reversed(letters)), (*numbers, 1)


_AXES2TUPLE = dict(_axes_tuples())
"""As in transformations.py: the first axis, whether the next is the one before it in x-y-z order (parity),
whether the last is the first again (repetition), and whether the axes rotate (frame)."""
_TUPLE2AXES = {numbers: axes for axes, numbers in _AXES2TUPLE.items()}


def _parse(axes: str) -> _Axes:
    frame, letters = axes[:1], axes[1:]
    neighbours = pairwise(letters)
    if frame not in ('s', 'r') or len(letters) != 3 or set(letters) - set('xyz'):
        raise ValueError(f"axes {axes!r}: write 's' (fixed) or 'r' (turning), then three axes, as in 'sxyz'")
    if any(one == next_one for one, next_one in neighbours):
        raise ValueError(f'axes {axes!r}: two turns in a row about one axis are one turn')
    order = letters if frame == 's' else letters[::-1]  # rotating axes equal fixed axes in reverse order
    first, second, third = ('xyz'.index(letter) for letter in order)
    return _Axes(first, second, third, frame == 'r')


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = 'sxyz') -> Array:
    """Return the quaternion of a rotation by three angles. Raises ValueError for unknown axes."""
    parsed = _parse(axes)
    angles = (ak, aj, ai) if parsed.turning else (ai, aj, ak)
    turns = [
        quaternion_about_axis(angle, np.eye(3)[axis]) for angle, axis in zip(angles, parsed[:3], strict=True)
    ]
    return reduce(lambda done, turn: quaternion_multiply(turn, done), turns)


def euler_matrix(ai: float, aj: float, ak: float, axes: str = 'sxyz') -> Array:
    """Return the 4 x 4 matrix of a rotation by three angles. Raises ValueError for unknown axes."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: ArrayLike, axes: str = 'sxyz') -> tuple[float, float, float]:
    """Return the three Euler angles of a rotation. Raises ValueError for unknown axes.

    In a gimbal lock only the sum or difference of the outer two angles is determined. Then the last angle is
    0 for fixed axes, and the first angle is 0 for rotating axes.
    """
    m, (i, j, third, turning) = floats(matrix)[:3, :3], _parse(axes)
    k = 3 - i - j
    sign = 1 if (j - i) % 3 == 1 else -1  # 1 if the axes are right-handed in this order
    if third == i:
        sine = hypot(m[i, j], m[i, k])
        middle = atan2(sine, m[i, i])
        outer, outer_lock = (atan2(m[i, j], m[i, k]), atan2(m[j, i], -m[k, i])), sine < _LOCKED
    else:
        cosine = hypot(m[i, i], m[j, i])
        middle = atan2(-m[k, i], cosine)
        outer, outer_lock = (atan2(m[k, j], m[k, k]), atan2(m[j, i], m[i, i])), cosine < _LOCKED
    if outer_lock:
        outer = (atan2(-m[j, k], m[j, j]), 0.0)
    angles = (sign * outer[0], sign * middle, sign * outer[1])
    return angles[::-1] if turning else angles


def euler_from_quaternion(quaternion: ArrayLike, axes: str = 'sxyz') -> tuple[float, float, float]:
    """Return the three Euler angles of a rotation, by the rules of euler_from_matrix."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)
