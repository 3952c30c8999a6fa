"""Rigid transforms: a rotation (unit quaternion x, y, z, w), then a translation (metres)."""

from __future__ import annotations

from math import acos, atan2, copysign, sin, sqrt
from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]

NO_ROTATION: Quaternion = (0.0, 0.0, 0.0, 1.0)
_NEARLY_PARALLEL = 1.0 - 1e-10
_TINY = 1e-12  # an angle with a smaller sine counts as 0


class Rigid(NamedTuple):
    """A rigid transform: converts the coordinates of a point from one frame to another."""

    translation: Vector
    rotation: Quaternion

    def apply(self, point: Vector) -> Vector:
        """Return the transformed point."""
        return _add(rotate(self.rotation, point), self.translation)

    def after(self, first: Rigid) -> Rigid:
        """Return the transform that applies `first`, then this transform."""
        return Rigid(self.apply(first.translation), multiply(self.rotation, first.rotation))

    def inverse(self) -> Rigid:
        """Return the inverse of this transform."""
        x, y, z, w = self.rotation
        back: Quaternion = (-x, -y, -z, w)
        moved = rotate(back, self.translation)
        return Rigid((-moved[0], -moved[1], -moved[2]), back)

    def towards(self, other: Rigid, ratio: float) -> Rigid:
        """Interpolate between this transform (ratio 0) and `other` (1): on a straight line, by the shorter
        turn.
        """
        (a, b, c), (d, e, f) = self.translation, other.translation
        between = (a + (d - a) * ratio, b + (e - b) * ratio, c + (f - c) * ratio)
        return Rigid(between, slerp(self.rotation, other.rotation, ratio))


IDENTITY = Rigid((0.0, 0.0, 0.0), NO_ROTATION)


def multiply(left: Quaternion, right: Quaternion) -> Quaternion:
    """Return the rotation that applies `right`, then `left`."""
    x1, y1, z1, w1 = left
    x2, y2, z2, w2 = right
    return (
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """Return a vector rotated by a unit quaternion."""
    x, y, z, w = rotation
    axis = (x, y, z)
    turned = cross(axis, vector)
    a, b, c = cross(axis, (turned[0] + w * vector[0], turned[1] + w * vector[1], turned[2] + w * vector[2]))
    return vector[0] + 2 * a, vector[1] + 2 * b, vector[2] + 2 * c


def cross(left: Vector, right: Vector) -> Vector:
    """Return the cross product of two vectors."""
    a, b, c = left
    d, e, f = right
    return b * f - c * e, c * d - a * f, a * e - b * d


def difference(left: Vector, right: Vector) -> Vector:
    """Return the vector `left` minus `right`."""
    return left[0] - right[0], left[1] - right[1], left[2] - right[2]


def scale(vector: Vector, factor: float) -> Vector:
    """Return a vector multiplied by a factor."""
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def conjugate(rotation: Quaternion) -> Quaternion:
    """Return the inverse of a rotation."""
    x, y, z, w = rotation
    return -x, -y, -z, w


def rotation_vector(rotation: Quaternion) -> Vector:
    """Return a rotation as a vector: its direction is the axis, its length the angle in rad (the shorter
    turn).
    """
    x, y, z, w = rotation if rotation[3] >= 0 else (-part for part in rotation)
    sine = sqrt(x * x + y * y + z * z)
    factor = 2.0 if sine < _TINY else 2 * atan2(sine, w) / sine
    return x * factor, y * factor, z * factor


def yaw_of(rotation: Quaternion) -> float:
    """Return the heading of a rotation: the angle in rad about z, as REP 103 counts it, -pi to pi."""
    x, y, z, w = rotation
    return atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def norm_squared(rotation: Quaternion) -> float:
    """Return the sum of the squares of a quaternion's parts, which is 1 for a rotation."""
    x, y, z, w = rotation
    return x * x + y * y + z * z + w * w


def normalize(rotation: Quaternion) -> Quaternion:
    """Return a quaternion scaled to length 1; the identity for a quaternion of length 0."""
    length = sqrt(norm_squared(rotation))
    if length == 0:
        return NO_ROTATION
    x, y, z, w = rotation
    return x / length, y / length, z / length, w / length


def canonical(rotation: Quaternion) -> Quaternion:
    """Of the two quaternions that stand for a rotation, return the one that tf2 returns.

    tf2 computes it from a matrix: w is positive for turns of less than 120 degrees, else the largest of x, y
    and z is positive.
    """
    x, y, z, w = normalize(rotation)
    leading = w if 4 * w * w > 1 else max(x, y, z, key=abs)
    sign = copysign(1.0, leading)
    return sign * x, sign * y, sign * z, sign * w


def slerp(start: Quaternion, end: Quaternion, ratio: float) -> Quaternion:
    """Interpolate between two rotations (ratio 0 to 1), at constant angular velocity along the
    shorter turn.
    """
    cosine = sum(a * b for a, b in zip(start, end, strict=True))
    sign = copysign(1.0, cosine)
    if abs(cosine) > _NEARLY_PARALLEL:
        one, two = 1.0 - ratio, sign * ratio
    else:
        angle = acos(abs(cosine))
        one, two = sin((1.0 - ratio) * angle) / sin(angle), sign * sin(ratio * angle) / sin(angle)
    (a, b, c, d), (e, f, g, h) = start, end
    return normalize((one * a + two * e, one * b + two * f, one * c + two * g, one * d + two * h))


def _add(left: Vector, right: Vector) -> Vector:
    return left[0] + right[0], left[1] + right[1], left[2] + right[2]
