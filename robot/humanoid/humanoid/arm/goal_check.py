"""Which arm goals are refused, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from humanoid.joints.commands import CommandRefused, Point, plan
from humanoid.model import JointSpec

SHORTEST, LONGEST = 0.01, 3600.0  # s: limits of a goal's duration


def refusal(
    names: Sequence[str],
    positions: Sequence[float],
    duration: float,
    *,
    here: Mapping[str, float],
    busy: Collection[str],
    joints: Mapping[str, JointSpec],
) -> str | None:
    """Return why the goal is refused, or None. Angles in rad; `here`: the joints' last known angles."""
    if not names:
        return 'it names no joint'
    if not SHORTEST <= duration <= LONGEST:  # NaN included
        return f'duration {duration} s is not a time from {SHORTEST:g} to {LONGEST:g} s'
    try:
        plan(names, [Point(duration, positions)], joints)
    except CommandRefused as refused:
        return str(refused)
    for name, position in zip(names, positions, strict=True):
        if name in busy:
            return f'{name} is moving for another goal; cancel that one first'
        if name not in here:
            return f'nothing is known of {name} yet: no joint state has shown it'
        speed, joint = abs(position - here[name]) / duration, joints[name]
        if speed > joint.max_velocity:
            unit = f'{joint.unit}/s'
            return f'{name} would need {speed:.2f} {unit}, its limit is {joint.max_velocity} {unit}'
    return None
