"""The published joints, free or following another joint, and their values in a message.

The rules are those of the package of this name: https://github.com/ros/joint_state_publisher
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from goalwire.records import record
from goalwire.transforms.urdf import Joint, Kinematics, Mimic


class UnusableJointsError(ValueError):
    """The joints cannot be published; the text says why."""


@record
class JointSettings:
    """The settings of joints, from the program's parameters."""

    zeros: Mapping[str, float]
    """The first positions of joints, by name."""
    dependents: Mapping[str, Mimic]
    """Joints that follow another joint, in addition to the mimic joints of the URDF."""
    use_mimic_tags: bool = True
    use_smallest_joint_limits: bool = True
    positions: bool = True
    """True if joints have positions before a source publishes any; `velocities` and `efforts` likewise."""
    velocities: bool = False
    efforts: bool = False


class FreeJoint:
    """A joint with a position of its own, in rad or m."""

    def __init__(self, name: str, limits: tuple[float, float], zero: float, *, is_continuous: bool) -> None:
        self.name = name
        self.lower, self.upper = limits
        self.zero = zero
        self.position: float | None = None
        self.velocity: float | None = None
        self.effort: float | None = None
        self._is_continuous = is_continuous
        self._rises = True

    def move(self, delta: float) -> None:
        """Move on by `delta`. At a limit the direction reverses; a continuous joint wraps round."""
        position = (self.position or 0.0) + (delta if self._rises else -delta)
        if position > self.upper and self._is_continuous:
            position = self.lower
        elif not self.lower <= position <= self.upper:
            position = min(max(position, self.lower), self.upper)
            self._rises = not self._rises
        self.position = position


@record
class Leader:
    """The free joint that another joint follows, perhaps through others."""

    joint: FreeJoint
    factor: float = 1.0
    offset: float = 0.0


class JointTable:
    """All movable joints of one description."""

    def __init__(self, robot: Kinematics, settings: JointSettings) -> None:
        """Raises UnusableJointsError."""
        by_name = {joint.name: joint for joint in robot.joints}
        movable = [by_name[name] for name in robot.joint_names if by_name[name].is_movable]
        followers = {
            joint.name: joint.mimic
            for joint in movable
            if joint.mimic is not None and settings.use_mimic_tags
        }
        known = {joint.name for joint in movable}
        followers |= {name: mimic for name, mimic in settings.dependents.items() if name in known}
        self.free = {joint.name: _make(joint, settings) for joint in movable if joint.name not in followers}
        self._leaders = {joint.name: _find_leader(joint.name, followers, self.free) for joint in movable}
        self._has_followers = bool(followers)

    def take(
        self,
        names: Sequence[str],
        positions: Sequence[float],
        velocities: Sequence[float],
        efforts: Sequence[float],
    ) -> None:
        """Take the values of free joints from a message; missing and infinite values are ignored."""
        for index, name in enumerate(names):
            joint = self.free.get(name)
            if joint is None:
                continue
            for part, values in (('position', positions), ('velocity', velocities), ('effort', efforts)):
                if index < len(values) and math.isfinite(values[index]):
                    setattr(joint, part, float(values[index]))

    def move(self, delta: float) -> None:
        """Move every free joint one step on."""
        for joint in self.free.values():
            joint.move(delta)

    def fill(self) -> tuple[list[str], list[float], list[float], list[float]]:
        """Return lists of names, positions, velocities and efforts; without any value a list is empty."""
        free = self.free.values()
        positions, velocities, efforts = [], [], []
        if self._has_followers or any(joint.position is not None for joint in free):
            positions = [each.factor * (each.joint.position or 0.0) + each.offset for each in self._all()]
        if any(joint.velocity is not None for joint in free):
            velocities = [each.factor * (each.joint.velocity or 0.0) for each in self._all()]
        if any(joint.effort is not None for joint in free):
            efforts = [each.joint.effort or 0.0 for each in self._all()]
        return list(self._leaders), positions, velocities, efforts

    def _all(self) -> list[Leader]:
        return list(self._leaders.values())


def _make(joint: Joint, settings: JointSettings) -> FreeJoint:
    lower, upper = joint.lower, joint.upper
    if settings.use_smallest_joint_limits:
        lower, upper = max(lower, joint.soft_lower), min(upper, joint.soft_upper)
    middle = (lower + upper) / 2 if lower > 0 or upper < 0 else 0.0
    zero = settings.zeros.get(joint.name, middle)
    made = FreeJoint(joint.name, (lower, upper), zero, is_continuous=joint.kind == 'continuous')
    made.position = zero if settings.positions else None
    made.velocity = 0.0 if settings.velocities else None
    made.effort = 0.0 if settings.efforts else None
    return made


def _find_leader(name: str, followers: Mapping[str, Mimic], free: Mapping[str, FreeJoint]) -> Leader:
    factor, offset = 1.0, 0.0
    way = [name]
    while name in followers:
        mimic = followers[name]
        offset += factor * mimic.offset
        factor *= mimic.multiplier
        name = mimic.joint
        if name in way:
            raise UnusableJointsError(f'joints follow each other in a circle: {" -> ".join([*way, name])}')
        way.append(name)
    if name not in free:
        raise UnusableJointsError(f"the joint '{way[-2]}' follows '{name}', which is not a movable joint")
    return Leader(free[name], factor, offset)
