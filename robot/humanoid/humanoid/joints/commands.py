"""What a joint command asks for: per joint, angles to pass at given times."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from humanoid.model import JointSpec
from humanoid.text import quoted

MOST_POINTS = 1000  # in one trajectory


class CommandRefused(ValueError):
    """The command names something that the joints cannot do; nothing of it was carried out."""


@dataclass(frozen=True)
class Waypoint:
    """Be at `position` (rad, or m), `time` seconds after the command's start."""

    time: float
    position: float


Plan = Mapping[str, Sequence[Waypoint]]


def plan(
    names: Sequence[str],
    points: Sequence[tuple[float, Sequence[float]]],
    joints: Mapping[str, JointSpec],
) -> dict[str, list[Waypoint]]:
    """Check a trajectory and sort it by joint.

    `points` are pairs of the time from start (s) and one position per name (rad), as in
    trajectory_msgs/JointTrajectory. Without points the plan is empty for each name: hold it where it is.
    Raises CommandRefused.
    """
    for name in names:
        if name not in joints:
            raise CommandRefused(f'unknown joint {quoted(name)}; the robot has {", ".join(sorted(joints))}')
    if len(set(names)) != len(names):
        raise CommandRefused(f'a joint is named twice in {quoted(", ".join(names))}')
    if len(points) > MOST_POINTS:
        raise CommandRefused(f'{len(points)} points are more than {MOST_POINTS}')
    previous = -math.inf
    for time, positions in points:
        if not previous < time or time < 0 or not math.isfinite(time):
            raise CommandRefused(f'time_from_start must be 0 or more and grow by point, got {time}')
        if len(positions) != len(names):
            raise CommandRefused(f'{len(positions)} positions for {len(names)} joints at {time} s')
        for name, position in zip(names, positions, strict=True):
            check_limits(joints[name], position)
        previous = time
    return {
        name: [Waypoint(time, positions[index]) for time, positions in points]
        for index, name in enumerate(names)
    }


def check_limits(joint: JointSpec, position: float) -> None:
    """Raise CommandRefused where `joint` cannot be at `position` (NaN included)."""
    if not joint.lower <= position <= joint.upper:
        raise CommandRefused(
            f'{joint.name} cannot go to {position} {joint.unit}; '
            f'its limits are {joint.lower} to {joint.upper} {joint.unit}'
        )
