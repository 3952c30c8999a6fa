"""Simulated joints: they follow commands as fast as their velocity limits allow, within position limits."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from humanoid.joints.commands import Plan, Waypoint
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME, JointSpec


@dataclass(frozen=True)
class Path:
    """The path of one joint through waypoints, interpolated as by ros2_control's joint_trajectory_controller.

    Between two waypoints it is linear if one of them has no velocity, cubic if both have velocities, and a
    quintic polynomial if both have accelerations, too.
    """

    start: float
    waypoints: Sequence[Waypoint]

    @classmethod
    def begin(cls, start: float, here: JointSample, waypoints: Sequence[Waypoint]) -> Path:
        """Return a path from the joint's present state, or from the first waypoint if that has time 0."""
        if waypoints[0].time > 0.0:
            return cls(start, [Waypoint(0.0, here.position, here.velocity), *waypoints])
        return cls(start, waypoints)

    def position_at(self, now: float) -> float:
        return self.at(now)[0]

    def at(self, now: float) -> tuple[float, float]:
        """Return the joint's position and velocity at a time: rad and rad/s, or m and m/s."""
        time = now - self.start
        after = bisect_right(self.waypoints, time, key=lambda waypoint: waypoint.time)
        if after in (0, len(self.waypoints)):
            return self.waypoints[min(after, len(self.waypoints) - 1)].position, 0.0
        a, b = self.waypoints[after - 1], self.waypoints[after]
        position = velocity = 0.0
        for factor in reversed(_polynomial(a, b)):
            velocity = velocity * (time - a.time) + position
            position = position * (time - a.time) + factor
        return position, velocity


def _polynomial(a: Waypoint, b: Waypoint) -> Sequence[float]:
    """Return the coefficients of the polynomial from waypoint `a` to `b`, in the time (s) since `a`."""
    t, way = b.time - a.time, b.position - a.position
    if a.velocity is None or b.velocity is None:
        return a.position, way / t
    v, w = a.velocity, b.velocity
    if a.acceleration is None or b.acceleration is None:
        return a.position, v, (3.0 * way - (2.0 * v + w) * t) / t**2, ((v + w) * t - 2.0 * way) / t**3
    c, d = a.acceleration, b.acceleration
    return (
        a.position,
        v,
        c / 2.0,
        (20.0 * way - (8.0 * w + 12.0 * v) * t - (3.0 * c - d) * t**2) / (2.0 * t**3),
        (-30.0 * way + (14.0 * w + 16.0 * v) * t + (3.0 * c - 2.0 * d) * t**2) / (2.0 * t**4),
        (12.0 * way - 6.0 * (w + v) * t + (d - c) * t**2) / (2.0 * t**5),
    )


class KinematicJoints:
    """A JointSource that simulates the joints: with speed limits, without mass; effort is friction alone."""

    def __init__(self, joints: Mapping[str, JointSpec] = JOINT_BY_NAME, now: float = 0.0) -> None:
        self._joints = joints
        self._now = now
        self._samples = {name: JointSample(joint.home, 0.0, 0.0) for name, joint in joints.items()}
        self._paths: dict[str, Path] = {}

    @property
    def joints(self) -> Mapping[str, JointSpec]:
        return self._joints

    def read(self, name: str) -> JointSample:
        return self._samples[name]

    def follow(self, plan: Plan, start: float) -> None:
        for name, waypoints in plan.items():
            if waypoints:
                self._paths[name] = Path.begin(start, self._samples[name], waypoints)
            else:
                self._paths.pop(name, None)

    def update(self, now: float) -> None:
        elapsed, self._now = now - self._now, now
        if elapsed > 0.0:  # while the clock stands still or is set back, no joint moves
            for name, joint in self._joints.items():
                self._samples[name] = self._step(joint, elapsed)

    def _step(self, joint: JointSpec, elapsed: float) -> JointSample:
        before = self._samples[joint.name].position
        path = self._paths.get(joint.name)
        wanted = path.position_at(self._now) if path else before
        reach = joint.max_velocity * elapsed
        after = min(max(wanted, before - reach, joint.lower), before + reach, joint.upper)
        velocity = (after - before) / elapsed
        return JointSample(after, velocity, joint.friction * velocity)
