"""The interface of a base, and a simulated base: it drives straight to its target at a bounded speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from humanoid.model import BASE, DESCRIPTION, BaseSpec


@dataclass(frozen=True)
class Pose2D:
    """A pose on the floor: metres, and the heading in rad, counter-clockwise from x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Velocity2D:
    """A velocity in the base's own frame, x forward: m/s and rad/s."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


STANDING = Velocity2D()
VELOCITY_LASTS = 0.5  # s: without a newer velocity from outside the base stops after this time
PELVIS = -DESCRIPTION.pose('base_footprint', {}).translation[2]  # m: height of base_link on straight legs


@dataclass(frozen=True)
class Placement:
    """Where base_link is and how it moves: height above the floor in m, `tilt` is roll and pitch in rad."""

    pose: Pose2D
    height: float
    tilt: tuple[float, float]
    velocity: Velocity2D


class MobileBase(Protocol):
    """The base of one robot. The class `Base` simulates it without mass; others use physics or hardware.

    All calls come from one thread, `step` 50 times a second; none may block for longer than a few
    milliseconds.
    """

    @property
    def pose(self) -> Pose2D:
        """The pose of the base now."""

    @property
    def height(self) -> float:
        """How high base_link is above the floor now, in m."""

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of base_link now, in rad."""

    @property
    def velocity(self) -> Velocity2D:
        """The velocity of the base now."""

    @property
    def arrived(self) -> bool:
        """True if the base is at its target."""

    def drive_to(self, target: Pose2D) -> None:
        """Drive to a target; a newer target replaces the older one."""

    def drive_at(self, velocity: Velocity2D) -> None:
        """Move at a velocity in the base's own frame, within its limits, until the next command."""

    def stop(self) -> None:
        """Stop moving."""

    def distance_to(self, target: Pose2D) -> float:
        """Return the distance to a target, in m."""

    def step(self, elapsed: float, /) -> None:
        """Advance a simulated base by `elapsed` s; other bases move by themselves and do nothing here."""


@runtime_checkable
class LimitedBase(Protocol):
    """A base that knows its limits before it moves."""

    def limit(self, velocity: Velocity2D) -> Velocity2D:
        """Return the velocity at which the base moves if `velocity` is asked for."""


@runtime_checkable
class SimulatedBase(Protocol):
    """A simulated base: the simulation knows the true pose, from which odometry may differ."""

    @property
    def truth(self) -> Placement:
        """The true pose and velocity now, relative to the start pose."""


class Base:
    """Drives to one target at a time, or at a velocity.

    It starts and stops instantly: its speed is bounded, its acceleration is not.
    """

    def __init__(self, spec: BaseSpec = BASE) -> None:
        self._spec = spec
        self._target: Pose2D | None = None
        self._asked = STANDING  # the velocity to keep while there is no target
        self.pose = Pose2D()
        self.height, self.tilt = PELVIS, (0.0, 0.0)
        self.velocity = STANDING

    @property
    def truth(self) -> Placement:
        return Placement(self.pose, self.height, self.tilt, self.velocity)

    def drive_to(self, target: Pose2D) -> None:
        self._target = target

    def drive_at(self, velocity: Velocity2D) -> None:
        """Move at a velocity; a velocity beyond the base's limits is scaled down to them."""
        self._target = None
        self._asked = self.limit(velocity)

    def limit(self, velocity: Velocity2D) -> Velocity2D:
        """Return the velocity at which the base moves if `velocity` is asked for."""
        speed, spec = math.hypot(velocity.x, velocity.y), self._spec
        share = min(1.0, spec.max_speed / speed) if speed > 0.0 else 1.0
        turn = min(max(velocity.yaw, -spec.max_turn_rate), spec.max_turn_rate)
        return Velocity2D(velocity.x * share, velocity.y * share, turn)

    def stop(self) -> None:
        self._target, self._asked = None, STANDING
        self.velocity = STANDING

    @property
    def arrived(self) -> bool:
        return self.pose == self._target

    def distance_to(self, target: Pose2D) -> float:
        return math.hypot(target.x - self.pose.x, target.y - self.pose.y)

    def step(self, elapsed: float) -> None:
        """Move for `elapsed` seconds; do nothing if it is 0 or negative, as after a clock was set back."""
        if elapsed <= 0.0:
            return
        if self._target is None:
            self._move(elapsed)
            return
        before, target = self.pose, self._target
        distance = self.distance_to(target)
        share = min(1.0, self._spec.max_speed * elapsed / distance) if distance > 0.0 else 1.0
        turn = turn_between(before.yaw, target.yaw)
        most = self._spec.max_turn_rate * elapsed
        self.pose = Pose2D(
            target.x if share == 1.0 else before.x + (target.x - before.x) * share,
            target.y if share == 1.0 else before.y + (target.y - before.y) * share,
            target.yaw if abs(turn) <= most else before.yaw + math.copysign(most, turn),
        )
        self.velocity = _velocity(before, self.pose, elapsed)

    def _move(self, elapsed: float) -> None:
        """Move at the requested velocity along an arc, whose chord is taken at the arc's mean heading."""
        if self._asked == self.velocity == STANDING:
            return
        asked, pose = self._asked, self.pose
        yaw = pose.yaw + asked.yaw * elapsed
        cos, sin = (
            math.cos(pose.yaw + asked.yaw * elapsed / 2.0),
            math.sin(pose.yaw + asked.yaw * elapsed / 2.0),
        )
        self.pose = Pose2D(
            pose.x + (cos * asked.x - sin * asked.y) * elapsed,
            pose.y + (sin * asked.x + cos * asked.y) * elapsed,
            math.remainder(yaw, math.tau),
        )
        self.velocity = asked


def _velocity(before: Pose2D, after: Pose2D, elapsed: float) -> Velocity2D:
    """Return the velocity that leads from one pose to the next, in the base's frame."""
    vx, vy = (after.x - before.x) / elapsed, (after.y - before.y) / elapsed
    cos, sin = math.cos(after.yaw), math.sin(after.yaw)
    return Velocity2D(cos * vx + sin * vy, cos * vy - sin * vx, turn_between(before.yaw, after.yaw) / elapsed)


def turn_between(start: float, end: float) -> float:
    """Return the shortest turn from one heading to another, in rad from -π to π."""
    return math.remainder(end - start, math.tau)


def compose(frame: Pose2D, pose: Pose2D) -> Pose2D:
    """Transform `pose`, given relative to `frame`, into the frame in which `frame` itself is given."""
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    return Pose2D(
        frame.x + cos * pose.x - sin * pose.y,
        frame.y + sin * pose.x + cos * pose.y,
        math.remainder(frame.yaw + pose.yaw, math.tau),
    )


def invert(pose: Pose2D) -> Pose2D:
    """Return the inverse of `pose`: the pose of the origin in the frame of `pose`."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, -pose.yaw)


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Return the heading of a quaternion of any length; all zeros mean heading 0."""
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
