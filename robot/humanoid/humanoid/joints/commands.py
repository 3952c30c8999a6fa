"""Turns a joint command into a plan: per joint, angles to pass at given times."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from humanoid.model import MOVING_SPEED, JointSpec
from humanoid.text import quote

MOST_POINTS = 1000  # in one trajectory
GREATEST_ACCELERATION = 1e6  # rad/s², m/s²: a larger acceleration could overflow a path's arithmetic


class CommandRefused(ValueError):
    """The joints cannot do what the command asks; no part of it was carried out."""


@dataclass(frozen=True)
class Waypoint:
    """The joint shall be at `position` (rad or m) `time` seconds after the command's start.

    The velocity (rad/s or m/s) and the acceleration (rad/s² or m/s²) are optional.
    """

    time: float
    position: float
    velocity: float | None = None
    acceleration: float | None = None


class Point(NamedTuple):
    """A trajectory's point: s from its start, and numbers for each joint, of which positions are required."""

    time: float
    positions: Sequence[float]
    velocities: Sequence[float] = ()
    accelerations: Sequence[float] = ()


Plan = Mapping[str, Sequence[Waypoint]]


def plan(
    names: Sequence[str], points: Sequence[Point], joints: Mapping[str, JointSpec]
) -> dict[str, list[Waypoint]]:
    """Check a trajectory, and return each joint's waypoints.

    Without points, each joint gets an empty plan, which means: hold. Raises CommandRefused.
    """
    for name in names:
        if name not in joints:
            raise CommandRefused(f'unknown joint {quote(name)}; the robot has {", ".join(sorted(joints))}')
    if len(set(names)) != len(names):
        raise CommandRefused(f'a joint is named twice in {quote(", ".join(names))}')
    if len(points) > MOST_POINTS:
        raise CommandRefused(f'{len(points)} points are more than {MOST_POINTS}')
    previous = -math.inf
    for point in points:
        time = point.time
        if not previous < time or time < 0 or not math.isfinite(time):
            raise CommandRefused(f'time_from_start must be 0 or more and grow by point, got {time}')
        if len(point.positions) != len(names):
            raise CommandRefused(f'{len(point.positions)} positions for {len(names)} joints at {time} s')
        for name, position in zip(names, point.positions, strict=True):
            check_limits(joints[name], position)
        _check_derivatives(names, point, joints, last=point is points[-1])
        previous = time
    return {
        name: [
            Waypoint(
                point.time,
                point.positions[index],
                point.velocities[index] if point.velocities else None,
                point.accelerations[index] if point.accelerations else None,
            )
            for point in points
        ]
        for index, name in enumerate(names)
    }


def _check_derivatives(
    names: Sequence[str], point: Point, joints: Mapping[str, JointSpec], *, last: bool
) -> None:
    """Check that velocities are within limits and zero at the end, and that accelerations are finite."""
    for what, values in (('velocities', point.velocities), ('accelerations', point.accelerations)):
        if len(values) not in (0, len(names)):
            raise CommandRefused(f'a point has {len(values)} {what} for {len(names)} joints')
    for name, velocity in zip(names, point.velocities, strict=False):
        joint = joints[name]
        most = joint.max_velocity * (1.0 + 1e-6)
        if not abs(velocity) <= most:
            raise CommandRefused(
                f'{name} cannot pass a point with {velocity} {joint.unit}/s; '
                f'its limit is {joint.max_velocity} {joint.unit}/s'
            )
        if last and abs(velocity) > MOVING_SPEED:
            raise CommandRefused(f'{name} would end with {velocity} {joint.unit}/s: the last point is a rest')
    for name, acceleration in zip(names, point.accelerations, strict=False):
        if not abs(acceleration) <= GREATEST_ACCELERATION:  # NaN included
            raise CommandRefused(
                f'the acceleration of {name} is {acceleration}, not a number up to {GREATEST_ACCELERATION:g}'
            )


def check_limits(joint: JointSpec, position: float) -> None:
    """Raise CommandRefused if `position` is beyond the limits of `joint`, or is NaN."""
    if not joint.lower <= position <= joint.upper:
        raise CommandRefused(
            f'{joint.name} cannot go to {position} {joint.unit}; '
            f'its limits are {joint.lower} to {joint.upper} {joint.unit}'
        )
